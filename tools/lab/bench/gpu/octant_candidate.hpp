#pragma once
#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/gpu/octant_levels.hpp"

// Backends that find the octants of the same cells, to be compared.
namespace oncollide::tools {

/// A backend in one of its variants.
struct OctantContender {
    std::string name;
    std::function<std::unique_ptr<OcclusionBackend>()> make;
    int threads = 1;
    bool lists = true; ///< false: it draws whole meshes, without using lists
};

/// @param each  also several threads, and all viewports and primitives of gl-query
std::vector<OctantContender> octant_contenders(int gpu, bool each);

/// The least time of repeats.
struct OctantTime {
    double ms = 1e300;
    double gpu_ms = 0; ///< of the same run, by the GPU's clock
};

/// A contender with a mesh, and the tree that it grew along the true cells.
class Candidate {
public:
    /// Keeps references to both.
    Candidate(const OctantContender& contender, const OctantLevels& levels);

    void start_again();

    /// Queries the cells of the next level and grows the tree; `see` receives each cell's true and found octants.
    template <class See>
    BatchWork grow_level(See see)
    {
        const auto& cells = levels_.level(grown_++);
        rows_.clear();
        for (const auto& cell : cells) rows_.push_back(row(cell.key));
        results_.resize(rows_.size());
        const BatchWork work = backend_->run(rows_, contender_.threads, results_);
        for (std::size_t i = 0; i < cells.size(); ++i) {
            see(cells[i].truth, results_[i].grey);
            results_[i].grey = cells[i].truth;
            tree_->expand(cells[i].key, results_[i], 1);
        }
        return work;
    }

    /// `count` queries of one level: the last level with at least this many cells, if there is one.
    OctantTime measure(std::size_t count, int repeats);
    /// The whole tree, one batch per level.
    OctantTime measure_tree(int depth, int repeats);

private:
    OctantRow row(CellKey cell) const;

    const OctantContender& contender_;
    const OctantLevels& levels_;
    std::unique_ptr<OcclusionBackend> backend_;
    std::optional<Ocst> tree_;
    int grown_ = 0; ///< levels
    std::vector<OctantRow> rows_;
    std::vector<OctantResult> results_;
};

} // namespace oncollide::tools
