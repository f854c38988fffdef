#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <oncollide/narrowphase/model.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/scenes/model/terrain/height_mover.hpp>
#include <oncollide/scenes/model/vertex_mover.hpp>

namespace oncollide {

/// The models of a World by slot, and transient models beside them.
class ModelTable {
public:
    /// @param world  the tag of the World in its ids
    explicit ModelTable(std::uint16_t world) : world_(world) {}

    ModelId add(std::shared_ptr<const Geometry> geometry);
    /// Makes a new model in the slot.
    void replace(ModelId id, std::shared_ptr<const Geometry> geometry);
    /// The model's geometry, to be changed and passed to replace(): a copy, unless the table already owns one.
    std::shared_ptr<Geometry> own(ModelId id);
    /// True after own_vertices(), until the model is replaced.
    bool owns_vertices(ModelId id) const { return slots_[id.slot].mover.has_value(); }
    /// Lets move_vertices() change the mesh in own(), which must be the model's geometry.
    void own_vertices(ModelId id);
    /// As VertexMover::move(). Call Model::deform() after it.
    VertexMove move_vertices(ModelId id, const std::string& name, std::size_t first,
                             std::span<const Eigen::Vector3d> positions);
    /// The same for the heights of a terrain, with HeightMover::move() and Model::change_heights().
    bool owns_heights(ModelId id) const { return slots_[id.slot].heights.has_value(); }
    void own_heights(ModelId id);
    HeightMove move_heights(ModelId id, const std::string& name, const TerrainRectangle& where,
                            std::span<const double> heights);
    void remove(ModelId id);
    bool valid(ModelId id) const { return alive(id.slot) && this->id(id.slot) == id; }
    ModelId id(std::uint32_t slot) const { return {slot, slots_[slot].generation, world_}; }
    std::size_t slots() const { return slots_.size(); }
    bool alive(std::size_t slot) const { return slot < slots_.size() && slots_[slot].model; }
    Model& operator[](ModelId id) const { return *slots_[id.slot].model; }
    std::size_t size() const { return size_; }

    /// Adds a model that lives as long as a query; not counted by size().
    Model& add_transient(std::shared_ptr<const Geometry> geometry);
    void remove_transient(Model& model);

    /// The model with this Model::number(): 2 * slot, odd for a transient model. Backends index arrays by number.
    Model& by_number(std::uint32_t number) const
    {
        return number % 2 ? *transient_[number / 2] : *slots_[number / 2].model;
    }

private:
    struct Slot {
        std::unique_ptr<Model> model;  ///< null: free
        std::shared_ptr<Geometry> own; ///< the model's geometry, if it is the table's own copy
        std::optional<VertexMover> mover;
        std::optional<HeightMover> heights;
        std::uint16_t generation = 1;
    };

    const std::uint16_t world_;
    std::vector<Slot> slots_;
    std::vector<std::uint32_t> free_;
    std::vector<std::unique_ptr<Model>> transient_;
    std::size_t size_ = 0;
};

} // namespace oncollide
