#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/pipeline/models/fault_log.hpp>
#include <oncollide/pipeline/models/obb_residency.hpp>

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
    /// As ModelTable::move_vertices(); the data derived from the old vertices is dropped, or follows them. Returns
    /// an upper bound of the distance that a vertex moved; 0: none did.
    double move_vertices(ModelId id, const std::string& name, std::size_t first,
                         std::span<const Eigen::Vector3d> positions);
    /// The same for the heights of a terrain.
    HeightMove move_heights(ModelId id, const std::string& name, const TerrainRectangle& where,
                            std::span<const double> heights);
    void remove(ModelId id);
    // The functions of ModelTable.
    bool owns_vertices(ModelId id) const { return models_.owns_vertices(id); }
    void own_vertices(ModelId id) { models_.own_vertices(id); }
    bool owns_heights(ModelId id) const { return models_.owns_heights(id); }
    void own_heights(ModelId id) { models_.own_heights(id); }
    std::shared_ptr<Geometry> own(ModelId id) { return models_.own(id); }
    bool valid(ModelId id) const { return models_.valid(id); }
    ModelId id(std::uint32_t slot) const { return models_.id(slot); }
    std::size_t slots() const { return models_.slots(); }
    bool alive(std::size_t slot) const { return models_.alive(slot); }
    Model& operator[](ModelId id) const { return models_[id]; }
    std::size_t size() const { return models_.size(); }

    /// Adds a model that lives as long as a query; not counted by size().
    Model& add_transient(std::shared_ptr<const Geometry> geometry);
    void remove_transient(Model& model);

    /// Error bound (metres) of the verdict `within` for this pair: Settings::max_error if set; else the bound that
    /// spheres at Settings::depth certify; else default_error times the smaller diagonal.
    double max_error(const Model& a, const Model& b) const;
    // The functions of SphereForest.
    void grow_ahead(bool on) { spheres_.grow_ahead(on); }
    Ocst& spheres(Model& model, double max_error) { return spheres_.tree(model, max_error); }
    bool has_spheres(const Model& model, double max_error) const { return spheres_.has_tree(model, max_error); }
    int depth(const Model& model, double max_error) const { return spheres_.depth(model, max_error); }
    // The functions of ObbResidency.
    bool admit_obb_tree(Model& model, std::uint32_t frame) { return obbs_.admit(model, frame); }
    ObbTree& obb_tree(Model& model, std::uint32_t frame) { return obbs_.tree(model, frame); }

    /// Calls work(), which traverses cooked meshes. If their budget is exhausted, drops the least recently needed
    /// chunks and calls work() again while no other traversal runs; so `work` must be repeatable. Throws the exceptions
    /// of `work`: ChunkFault if a file cannot be read or the budget is too small for it.
    template <class Work>
    auto with_room(Work work) const
    {
        return obbs_.chunks().with_room(std::move(work));
    }
    /// Makes another thread open these parts and grow their trees; replaces parts that still wait.
    void look_ahead(std::vector<PrefetchPart> parts) { obbs_.look_ahead(std::move(parts)); }

    /// Records the reason why a pair stays undecided.
    void note(const std::string& fault) const { faults_.note(fault); }
    /// Faults of cooked meshes, one line per chunk or budget, with the number of undecided results.
    std::vector<std::string> faults() const;

    OcclusionBackend& backend() const { return spheres_.backend(); }
    /// Why the GPU is no longer used; empty if it is still in use or never was.
    const std::string& lost() const { return spheres_.lost(); }

    /// As SphereForest::submit. Returns the number of cells that are left out because a budget is exceeded.
    std::uint64_t submit(std::span<const CellRequest> requests, int threads);
    BatchWork grow(std::uint32_t frame) { return spheres_.grow(frame); }

    /// Drops cells and nodes that no test has reached for the age limit; sooner, oldest first, while memory exceeds its
    /// budget. Detaches the surface of a tree that is back to its root. Returns the number of stored cells and nodes
    /// dropped.
    std::uint64_t age(std::uint32_t frame);

    std::uint64_t nodes() const { return spheres_.cells() + obbs_.nodes(); } ///< stored cells, and nodes of OBB trees
    std::size_t bytes() const { return spheres_.bytes() + obbs_.bytes(); }   ///< trees, surfaces and lists
    std::size_t links_bytes() const; ///< neighbours of triangles and joined faces, which no budget limits

private:
    void drop(Model& model);
    std::uint64_t collapse(std::uint32_t frame, std::uint32_t age);

    const Settings& settings_;
    ObbCounters counters_; ///< outlives the models
    SphereForest spheres_;
    ModelTable models_;
    ObbResidency obbs_; ///< its thread uses the models
    mutable FaultLog faults_;
    bool late_ = false; ///< true if the last collapse() was postponed because the prefetcher was busy
};

} // namespace oncollide
