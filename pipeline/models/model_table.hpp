#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include <oncollide/narrowphase/model.hpp>
#include <oncollide/pipeline/results.hpp>

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
        std::uint16_t generation = 1;
    };

    const std::uint16_t world_;
    std::vector<Slot> slots_;
    std::vector<std::uint32_t> free_;
    std::vector<std::unique_ptr<Model>> transient_;
    std::size_t size_ = 0;
};

} // namespace oncollide
