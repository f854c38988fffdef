#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <oncollide/narrowphase/pairs/pair_task.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/pipeline/world/manifold_join.hpp>

namespace oncollide {

struct WorldImpl;

/// The manifolds of the last frame's pairs, kept so that pairs whose bodies did not change are copied. A frame in which
/// nothing changed keeps them as they are.
class FrameManifoldCache {
public:
    /// As World::manifolds().
    const FrameManifolds& find(WorldImpl& world, const ManifoldOptions& options);
    /// Frame `frame` has the results of the one before, pair by pair.
    void repeat(std::uint32_t frame)
    {
        if (frame_ && *frame_ + 1 == frame) frame_ = frame;
    }
    std::size_t bytes() const;

private:
    static constexpr std::uint32_t none = ~0u;
    /// The pairs' places in the lists.
    struct Lists {
        FrameManifolds manifolds;
        std::vector<std::uint32_t> place; ///< by pair of the frame; none: it has no region
    };
    void choose_pairs(WorldImpl& world, const ManifoldOptions& options, bool reuse);
    void make_tasks(WorldImpl& world);
    void measure(WorldImpl& world, const ManifoldOptions& options);
    const FrameManifolds& limited(const ManifoldOptions& options);

    std::optional<std::uint32_t> frame_; ///< of `now_`
    ManifoldOptions options_;
    Lists now_, last_;
    FrameManifolds limited_;                 ///< with at most ManifoldOptions::points_in_all points
    std::vector<std::uint32_t> kept_from_;   ///< by pair: its place in last_; none: it is measured or has none
    std::vector<std::uint32_t> open_;        ///< pairs to measure, ascending
    std::vector<PairTask> tasks_, of_trees_; ///< tasks of the open pairs, and the tasks among them that need trees
    ManifoldJoin join_;
};

/// Pairs share at most this many points in turn, the deepest pair first. Both lists may be the same.
void limit_points(const ManifoldLists& lists, std::size_t most, ManifoldLists& limited);

} // namespace oncollide
