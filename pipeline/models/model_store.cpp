#include <oncollide/pipeline/models/model_store.hpp>

#include <algorithm>
#include <cmath>

namespace oncollide {

ModelStore::ModelStore(const Settings& settings, std::unique_ptr<OcclusionBackend> backend, std::uint16_t world)
    : settings_(settings), counters_{ChunkBudget(settings.resident_budget), {}},
      spheres_(settings, models_, std::move(backend)), models_(world), obbs_(settings, counters_, spheres_)
{
}

void ModelStore::drop(Model& model)
{
    obbs_.drop(model);
    spheres_.drop(model);
}

ModelId ModelStore::add(std::shared_ptr<const Geometry> geometry)
{
    const ModelId id = models_.add(std::move(geometry));
    obbs_.add(models_[id]);
    return id;
}

void ModelStore::replace(ModelId id, std::shared_ptr<const Geometry> geometry)
{
    drop(models_[id]);
    models_.replace(id, std::move(geometry));
    obbs_.add(models_[id]);
}

double ModelStore::move_vertices(ModelId id, const std::string& name, std::size_t first,
                                 std::span<const Eigen::Vector3d> positions)
{
    const VertexMove moved = models_.move_vertices(id, name, first, positions);
    if (moved.distance == 0) return 0;
    spheres_.drop(models_[id]);
    models_[id].deform(static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(positions.size()), moved.radius2);
    return moved.distance;
}

HeightMove ModelStore::move_heights(ModelId id, const std::string& name, const TerrainRectangle& where,
                                    std::span<const double> heights)
{
    const HeightMove moved = models_.move_heights(id, name, where, heights);
    if (moved.any()) models_[id].change_heights(where);
    return moved;
}

void ModelStore::remove(ModelId id)
{
    drop(models_[id]);
    models_.remove(id);
}

Model& ModelStore::add_transient(std::shared_ptr<const Geometry> geometry)
{
    Model& model = models_.add_transient(std::move(geometry));
    obbs_.add(model);
    return model;
}

void ModelStore::remove_transient(Model& model)
{
    drop(model);
    models_.remove_transient(model);
}

double ModelStore::max_error(const Model& a, const Model& b) const
{
    if (settings_.max_error) return *settings_.max_error;
    const double of_a = a.bounds().diagonal(), of_b = b.bounds().diagonal();
    return settings_.depth ? std::ldexp(of_a + of_b, -*settings_.depth) : default_error * std::min(of_a, of_b);
}

std::vector<std::string> ModelStore::faults() const
{
    std::vector<std::string> of_files;
    for (std::uint32_t slot = 0; slot < models_.slots(); ++slot)
        if (const CookedFile* file = models_.alive(slot) ? models_[models_.id(slot)].file() : nullptr)
            for (std::string& what : file->faults()) of_files.push_back(std::move(what));
    return faults_.lines(of_files);
}

std::uint64_t ModelStore::submit(std::span<const CellRequest> requests, int threads)
{
    std::uint64_t allowed = requests.size();
    if (settings_.node_budget) {
        const std::uint64_t held = spheres_.cells() + obbs_.reserved().nodes;
        // An expansion stores at most eight cells.
        allowed =
            settings_.node_budget > held ? std::min<std::uint64_t>(allowed, (settings_.node_budget - held) / 8) : 0;
    }
    if (settings_.memory_budget && spheres_.bytes() + obbs_.reserved().bytes >= settings_.memory_budget) allowed = 0;
    spheres_.submit(requests.first(allowed), threads);
    return requests.size() - allowed;
}

std::uint64_t ModelStore::collapse(std::uint32_t frame, std::uint32_t age)
{
    const std::optional<std::uint64_t> nodes = obbs_.collapse(frame, age);
    late_ = !nodes;
    return late_ ? 0 : *nodes + spheres_.collapse(frame, age); // else retried in the next frame
}

std::size_t ModelStore::links_bytes() const
{
    std::size_t sum = 0;
    for (std::uint32_t slot = 0; slot < slots(); ++slot)
        if (alive(slot)) sum += (*this)[id(slot)].links_bytes();
    return sum;
}

std::uint64_t ModelStore::age(std::uint32_t frame)
{
    auto limit = static_cast<std::uint32_t>(settings_.age_limit);
    obbs_.begin(frame);
    std::uint64_t dropped = 0;
    // Checking every cell is expensive; a few checks per age limit are enough.
    if (late_ || frame % std::max(1u, limit / 8) == 0) dropped = collapse(frame, limit);
    while (settings_.memory_budget && limit > 0 && bytes() > settings_.memory_budget) {
        limit /= 2;
        dropped += collapse(frame, limit);
    }
    return dropped;
}

} // namespace oncollide
