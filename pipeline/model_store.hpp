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
#include <oncollide/pipeline/settings.hpp>
#include <oncollide/scenes/ids.hpp>

namespace oncollide {

/// The models of a World, and the budgets and the ageing that their trees share.
class ModelStore {
public:
    /// Keeps a reference to the settings.
    ModelStore(const Settings& settings, std::unique_ptr<OcclusionBackend> backend);

    ModelId add(std::shared_ptr<const Geometry> geometry);
    /// The model gets another geometry; all that was derived from the old one goes.
    void replace(ModelId id, std::shared_ptr<const Geometry> geometry);
    /// The model's geometry, to be changed and given to replace(): a copy, unless nobody else has it any more.
    std::shared_ptr<Geometry> own(ModelId id);
    void remove(ModelId id);
    bool valid(ModelId id) const
    {
        return id.slot < slots_.size() && slots_[id.slot].model && slots_[id.slot].generation == id.generation;
    }
    Model& operator[](ModelId id) { return *slots_[id.slot].model; }
    const Model& operator[](ModelId id) const { return *slots_[id.slot].model; }
    std::size_t size() const { return size_; }

    /// A model that lives as long as a query; not counted by size().
    Model& add_transient(std::shared_ptr<const Geometry> geometry);
    void remove_transient(Model& model);

    /// The largest error of the verdict `within` for a pair of the two (metres): the settings', or what spheres of
    /// their depth certify, or default_error of the smaller one's diagonal.
    double max_error(const Model& a, const Model& b) const;
    /// The sphere-tree of a model, made of its root alone when it is first needed, for pairs with that error. Not while
    /// cells are being expanded.
    Ocst& spheres(Model& model, double max_error);
    /// Is its sphere-tree there, and deep enough?
    bool has_spheres(const Model& model, double max_error) const
    {
        return model.spheres && model.spheres->depth() >= depth(model, max_error);
    }
    /// The level at which walks of pairs with that error end: two such trees certify it. The tree must be there.
    int depth(const Model& model, double max_error) const;
    /// Sees to it that a mesh, or the core of a shape, has its tree of oriented boxes, and a map or a terrain its own.
    /// False when a budget has no room for the tree all grown, or the file of a cooked mesh cannot be read. Not while
    /// the model's tree is being walked, unless it is there.
    bool admit_obb_tree(Model& model, std::uint32_t frame);
    /// The same, whatever the budgets say; not for a map or a terrain.
    ObbTree& obb_tree(Model& model, std::uint32_t frame);

    /// work(), which walks cooked meshes. Where their budget is in the way, chunks that were not needed for longest are
    /// dropped, and it begins again, alone; it must not mind. Throws what it throws: ChunkFault where a file cannot be
    /// read, or the budget is too small for it.
    template <class Work>
    auto with_room(Work work) const;
    /// Has another thread open these parts and grow their trees, in place of what it was given before.
    void look_ahead(std::vector<PrefetchPart> parts);

    /// A pair stays undecided for this reason.
    void note(const std::string& fault) const;
    /// What went wrong with cooked meshes, a line for each chunk or budget, and how many pairs and frames it touched.
    std::vector<std::string> faults() const;

    OcclusionBackend& backend() { return *backend_; }
    const OcclusionBackend& backend() const { return *backend_; }

    /// Starts to expand the requested cells (sorted, each once) in one batch. Those over a budget are left; returns how
    /// many. Surfaces are handed to the backend when their tree first grows. Trees do not change until grow().
    std::uint64_t submit(std::span<const CellRequest> requests, int threads);
    /// Waits for the batch and lets the trees grow.
    BatchWork grow(std::uint32_t frame);

    /// Drops what no test has reached for the age limit, the oldest sooner while memory is over its budget. A tree that
    /// is back to its root gives its surface up too. Returns how many stored cells and nodes went.
    std::uint64_t age(std::uint32_t frame);

    /// Why the GPU is no longer used; empty while it is, or if it never was.
    const std::string& lost() const { return lost_; }

    std::uint64_t nodes() const; ///< stored cells of all sphere-trees, and nodes of oriented boxes
    std::size_t bytes() const;   ///< trees, surfaces and lists

private:
    struct Slot {
        std::unique_ptr<Model> model;  ///< null: free
        std::shared_ptr<Geometry> own; ///< the model's geometry, if it is a copy of the store's
        std::uint32_t generation = 0;
    };
    /// What trees may come to hold.
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
    std::unique_ptr<OcclusionBackend> backend_;
    BoxTotals boxes_; ///< of the models' trees that read no chunks
    // Model::number is 2 * slot for a model of a slot, odd for one that passes: backends keep arrays by number.
    mutable ChunkBudget chunks_; ///< before the models, which give back what they took
    std::vector<Slot> slots_;
    std::vector<std::uint32_t> free_;
    std::vector<std::unique_ptr<Model>> passing_;
    std::size_t size_ = 0;
    std::vector<std::uint32_t> with_spheres_; ///< numbers of models that have a sphere-tree
    std::vector<Model*> with_obb_trees_;          ///< models that have a tree of oriented boxes
    std::vector<Model*> with_chunks_;         ///< of these, those that read chunks
    Room reserved_;                           ///< for these, all grown
    std::vector<const Model*> grids_;         ///< terrains, and maps in files
    std::vector<OctantRow> rows_;             ///< of the batch under way
    std::vector<OctantResult> results_;
    int threads_ = 1;
    std::string lost_;
    mutable std::shared_mutex walking_; ///< shared by those who walk where chunks may be dropped
    mutable std::mutex noting_;
    mutable std::map<std::string, std::uint64_t> noted_; ///< pairs by reason

    /// A tree that another thread made before a pair needed it.
    struct Prepared {
        Model* model;
        std::unique_ptr<ObbTree> obb_tree;
        std::uint32_t frame; ///< when it was last wanted
    };
    mutable std::mutex preparing_; ///< of what follows, and of Model::boxes of cooked meshes while it is set
    std::vector<Prepared> prepared_;
    std::unique_ptr<Prefetcher> ahead_; ///< null until it is needed; ends before the rest
    std::uint32_t frame_ = 0;          ///< of the last age()
    bool late_ = false;                ///< should have dropped what is old, but the other thread was at it
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
