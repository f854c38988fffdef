#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <span>
#include <string>
#include <vector>

#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/spheres/occlusion_backend.hpp>
#include <oncollide/narrowphase/spheres/walk.hpp>
#include <oncollide/pipeline/prefetcher.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/pipeline/settings.hpp>

namespace oncollide {

/// The models of a World, and the budgets and ageing that their trees share.
class ModelStore {
public:
    /// Keeps a reference to the settings.
    /// @param world  the tag of the World in its ids
    ModelStore(const Settings& settings, std::unique_ptr<OcclusionBackend> backend, std::uint16_t world = 0);

    ModelId add(std::shared_ptr<const Geometry> geometry);
    /// Gives the model another geometry; drops all data derived from the old one.
    void replace(ModelId id, std::shared_ptr<const Geometry> geometry);
    /// The model's geometry, to be changed and passed to replace(): a copy, unless the store already owns one.
    std::shared_ptr<Geometry> own(ModelId id);
    void remove(ModelId id);
    bool valid(ModelId id) const { return id.slot < slots_.size() && slots_[id.slot].model && this->id(id.slot) == id; }
    ModelId id(std::uint32_t slot) const { return {slot, slots_[slot].generation, world_}; }
    std::size_t slots() const { return slots_.size(); }
    bool alive(std::size_t slot) const { return slot < slots_.size() && slots_[slot].model; }
    Model& operator[](ModelId id) { return *slots_[id.slot].model; }
    const Model& operator[](ModelId id) const { return *slots_[id.slot].model; }
    std::size_t size() const { return size_; }

    /// Adds a model that lives as long as a query; not counted by size().
    Model& add_transient(std::shared_ptr<const Geometry> geometry);
    void remove_transient(Model& model);

    /// Error bound (metres) of the verdict `within` for this pair: Settings::max_error if set; else the bound that
    /// spheres at Settings::depth certify; else default_error times the smaller diagonal.
    double max_error(const Model& a, const Model& b) const;
    /// The sphere-tree of a model, deep enough for pairs with that error; created with only its root at first use. Not
    /// while cells are being expanded.
    Ocst& spheres(Model& model, double max_error);
    /// True if the sphere-tree exists and is deep enough.
    bool has_spheres(const Model& model, double max_error) const
    {
        return model.spheres && model.spheres->depth() >= depth(model, max_error);
    }
    /// The level at which the traversals of pairs with that error end: two trees of this depth certify it. The tree
    /// must exist.
    int depth(const Model& model, double max_error) const;
    /// Ensures that a mesh or the core of a shape has its OBB tree, and a map or a terrain its own tree. False if a
    /// budget has no room for the fully grown tree, or the file of a cooked mesh cannot be read. Not during a traversal
    /// of the model's tree, unless the tree exists already.
    bool admit_obb_tree(Model& model, std::uint32_t frame);
    /// The same regardless of budgets; not for a map or a terrain.
    ObbTree& obb_tree(Model& model, std::uint32_t frame);

    /// Calls work(), which traverses cooked meshes. If their budget is exhausted, drops the least recently needed
    /// chunks and calls work() again while no other traversal runs; so `work` must be repeatable. Throws the exceptions
    /// of `work`: ChunkFault if a file cannot be read or the budget is too small for it.
    template <class Work>
    auto with_room(Work work) const;
    /// Makes another thread open these parts and grow their trees; replaces parts that still wait.
    void look_ahead(std::vector<PrefetchPart> parts);

    /// Records the reason why a pair stays undecided.
    void note(const std::string& fault) const;
    /// Faults of cooked meshes, one line per chunk or budget, with the number of undecided results.
    std::vector<std::string> faults() const;

    OcclusionBackend& backend() { return *backend_; }
    const OcclusionBackend& backend() const { return *backend_; }

    /// Starts to expand the requested cells (sorted, each once) in one batch. Returns the number of cells that are left
    /// out because a budget is exceeded. A surface is attached to the backend when its tree first grows. Trees do not
    /// change until grow().
    std::uint64_t submit(std::span<const CellRequest> requests, int threads);
    /// Waits for the batch and adds its cells to the trees.
    BatchWork grow(std::uint32_t frame);

    /// Drops cells and nodes that no test has reached for the age limit; sooner, oldest first, while memory exceeds its
    /// budget. Detaches the surface of a tree that is back to its root. Returns the number of stored cells and nodes
    /// dropped.
    std::uint64_t age(std::uint32_t frame);

    /// Why the GPU is no longer used; empty if it is still in use or never was.
    const std::string& lost() const { return lost_; }

    std::uint64_t nodes() const; ///< stored cells of all sphere-trees, and nodes of OBB trees
    std::size_t bytes() const;   ///< trees, surfaces and lists

private:
    struct Slot {
        std::unique_ptr<Model> model;  ///< null: free
        std::shared_ptr<Geometry> own; ///< the model's geometry, if it is the store's own copy
        std::uint16_t generation = 1;
    };
    /// Upper bounds on the size of trees.
    struct Room {
        std::uint64_t nodes = 0;
        std::size_t bytes = 0;
    };
    static Room all_grown(const Model& model);

    void make_obb_tree(Model& model, const Room& room);
    void prepare(const PrefetchPart& part);
    void drop_prepared(const Model* of, std::uint32_t frame, std::uint32_t age);
    void drop_chunks(std::size_t down_to) const;
    void drop(Model& model);
    Model& by_number(std::uint32_t number) const;
    std::uint64_t cells() const;
    std::size_t sphere_bytes() const;
    std::uint64_t collapse(std::uint32_t frame, std::uint32_t age);
    std::uint64_t drop_obb_tree(Model& model);
    void drop_spheres(std::uint32_t slot);
    void attach(std::uint32_t slot);
    void make_rows(std::span<const CellRequest> requests);
    void take_over(const GpuLost& why);
    template <class Work>
    void survive(Work work);
    std::unique_ptr<Model> make_model(std::shared_ptr<const Geometry> geometry, std::uint32_t number);

    const Settings& settings_;
    const std::uint16_t world_;
    std::unique_ptr<OcclusionBackend> backend_;
    BoxTotals boxes_; ///< of the OBB trees that read no chunks
    // Model::number is 2 * slot for a model with a slot and odd for a transient model: backends index arrays by number.
    mutable ChunkBudget chunks_; ///< declared before the models, whose destructors release chunks
    std::vector<Slot> slots_;
    std::vector<std::uint32_t> free_;
    std::vector<std::unique_ptr<Model>> passing_;
    std::size_t size_ = 0;
    std::vector<std::uint32_t> with_spheres_; ///< numbers of models with a sphere-tree
    std::vector<Model*> with_obb_trees_;      ///< models with an OBB tree
    std::vector<Model*> with_chunks_;         ///< the subset whose trees read chunks
    Room reserved_;                           ///< for with_obb_trees_, fully grown
    std::vector<const Model*> grids_;         ///< terrains, and maps in files
    std::vector<OctantRow> rows_;             ///< of the current batch
    std::vector<OctantResult> results_;
    int threads_ = 1;
    std::string lost_;
    mutable std::shared_mutex walking_; ///< locked shared by traversals whose chunks may be dropped
    mutable std::mutex noting_;
    mutable std::map<std::string, std::uint64_t> noted_; ///< pairs by reason

    /// An OBB tree made by the prefetcher before a pair needed it.
    struct Prepared {
        Model* model;
        std::unique_ptr<ObbTree> obb_tree;
        std::uint32_t frame; ///< when it was last requested
    };
    mutable std::mutex preparing_; ///< guards prepared_ and frame_, and the OBB trees of cooked meshes while a
                                   ///< prefetcher exists
    std::vector<Prepared> prepared_;
    std::unique_ptr<Prefetcher> ahead_; ///< null until needed; destroyed before the other members
    std::uint32_t frame_ = 0;           ///< of the last age()
    bool late_ = false;                 ///< true if the last collapse() was postponed because the prefetcher was busy
};

template <class Work>
auto ModelStore::with_room(Work work) const
{
    if (!chunks_.limited()) return work();
    try {
        const std::shared_lock lock(walking_);
        return work();
    } catch (const NoRoomForChunk&) {
    }
    const std::unique_lock lock(walking_);
    const Prefetcher::Pause pause(ahead_.get());
    try {
        drop_chunks(chunks_.limit() / 2);
        return work();
    } catch (const NoRoomForChunk&) {
    }
    drop_chunks(0);
    return work();
}

} // namespace oncollide
