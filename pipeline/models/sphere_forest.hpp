#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/narrowphase/spheres/occlusion_backend.hpp>
#include <oncollide/narrowphase/spheres/walk.hpp>
#include <oncollide/pipeline/models/model_table.hpp>
#include <oncollide/pipeline/settings.hpp>

namespace oncollide {

/// The sphere-trees of the models, which grow in batches on a backend. If a GPU is lost, the CPU takes over.
class SphereForest {
public:
    /// Keeps references to the settings and the models.
    SphereForest(const Settings& settings, const ModelTable& models, std::unique_ptr<OcclusionBackend> backend)
        : settings_(settings), models_(models), backend_(std::move(backend))
    {
    }

    /// The tree of a model, deep enough for pairs with that error; created with only its root at first use. Do not call
    /// it while cells are being expanded.
    Ocst& tree(Model& model, double max_error);
    /// True if the tree exists and is deep enough.
    bool has_tree(const Model& model, double max_error) const
    {
        return model.spheres() && model.spheres()->depth() >= depth(model, max_error);
    }
    /// The level at which the traversals of pairs with that error end: two trees of this depth certify it. The tree
    /// must exist.
    int depth(const Model& model, double max_error) const;

    /// Expands in each batch also the grey children of the cells of the batch before. For benchmarks: it counts towards
    /// no budget. Results stay the same.
    void grow_ahead(bool on) { grows_ahead_ = on; }
    /// Starts to expand the requested cells (sorted, each once) in one batch. A surface is attached to the backend when
    /// its tree first grows. Trees do not change until grow().
    void submit(std::span<const CellRequest> requests, int threads);
    /// Waits for the batch and adds its cells to the trees.
    BatchWork grow(std::uint32_t frame);

    /// Drops the cells that no test has reached for `age` frames. Detaches the surface of a tree that is back to its
    /// root. Returns the number of stored cells dropped.
    std::uint64_t collapse(std::uint32_t frame, std::uint32_t age);
    /// Drops the tree of a model.
    void drop(Model& model);

    OcclusionBackend& backend() const { return *backend_; }
    /// Why the GPU is no longer used; empty if it is still in use or never was.
    const std::string& lost() const { return lost_; }
    std::uint64_t cells() const; ///< stored
    std::size_t bytes() const;   ///< trees, surfaces and lists

private:
    Ocst& tree_of(std::uint32_t number) const { return *models_.by_number(number).spheres(); }
    void attach(std::uint32_t number);
    void make_rows(std::span<const CellRequest> requests);
    void take_over(const GpuLost& why);
    template <class Work>
    void survive(Work work);

    const Settings& settings_;
    const ModelTable& models_;
    std::unique_ptr<OcclusionBackend> backend_;
    std::vector<std::uint32_t> trees_; ///< numbers of the models with a tree
    std::vector<OctantRow> rows_;      ///< rows of the current batch
    std::vector<OctantResult> results_;
    std::vector<CellRequest> requests_; ///< requests of the batch, with those ahead
    bool grows_ahead_ = false;
    std::vector<CellRequest> ahead_; ///< requests for the next batch
    int threads_ = 1;
    std::string lost_;
};

} // namespace oncollide
