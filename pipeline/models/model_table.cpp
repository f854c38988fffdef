#include <oncollide/pipeline/models/model_table.hpp>

#include <algorithm>

namespace oncollide {

ModelId ModelTable::add(std::shared_ptr<const Geometry> geometry)
{
    if (free_.empty()) free_.push_back(static_cast<std::uint32_t>(slots_.size())), slots_.emplace_back();
    const std::uint32_t slot = free_.back();
    free_.pop_back();
    slots_[slot].model = std::make_unique<Model>(std::move(geometry), 2 * slot);
    ++size_;
    return id(slot);
}

void ModelTable::replace(ModelId id, std::shared_ptr<const Geometry> geometry)
{
    Slot& slot = slots_[id.slot];
    if (geometry != slot.own) slot.own.reset();
    slot.mover.reset(), slot.heights.reset();
    slot.model = std::make_unique<Model>(std::move(geometry), 2 * id.slot);
}

std::shared_ptr<Geometry> ModelTable::own(ModelId id)
{
    Slot& slot = slots_[id.slot];
    if (!slot.own) slot.own = std::make_shared<Geometry>(slot.model->geometry());
    return slot.own;
}

void ModelTable::own_vertices(ModelId id)
{
    Slot& slot = slots_[id.slot];
    ONCOLLIDE_ASSERT(&slot.model->geometry() == slot.own.get());
    slot.own->recipe.clear();
    slot.mover.emplace(std::get<Mesh>(slot.own->data));
}

VertexMove ModelTable::move_vertices(ModelId id, const std::string& name, std::size_t first,
                                     std::span<const Eigen::Vector3d> positions)
{
    Slot& slot = slots_[id.slot];
    return slot.mover->move(name, std::get<Mesh>(slot.own->data), first, positions);
}

void ModelTable::own_heights(ModelId id)
{
    Slot& slot = slots_[id.slot];
    ONCOLLIDE_ASSERT(&slot.model->geometry() == slot.own.get());
    slot.own->recipe.clear();
    slot.heights.emplace(std::get<Terrain>(slot.own->data));
}

HeightMove ModelTable::move_heights(ModelId id, const std::string& name, const TerrainRectangle& where,
                                    std::span<const double> heights)
{
    Slot& slot = slots_[id.slot];
    return slot.heights->move(name, std::get<Terrain>(slot.own->data), where, heights);
}

void ModelTable::remove(ModelId id)
{
    Slot& slot = slots_[id.slot];
    slot.model.reset(), slot.own.reset(), slot.mover.reset(), slot.heights.reset();
    if (slot.generation++ < last_generation) free_.push_back(id.slot);
    --size_;
}

Model& ModelTable::add_transient(std::shared_ptr<const Geometry> geometry)
{
    const auto free = std::find(transient_.begin(), transient_.end(), nullptr);
    const auto number = 2 * static_cast<std::uint32_t>(free - transient_.begin()) + 1;
    auto model = std::make_unique<Model>(std::move(geometry), number);
    return **(free == transient_.end() ? transient_.insert(free, std::move(model)) : (*free = std::move(model), free));
}

void ModelTable::remove_transient(Model& model)
{
    transient_[model.number() / 2].reset();
}

} // namespace oncollide
