#pragma once
#include <algorithm>

#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/pairs/manifolds/placed_surface.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>

namespace oncollide {

/// Two surfaces, and their manifold, to which each step appends regions.
struct ManifoldJob {
    const PlacedSurface &a, &b;
    const ManifoldOptions& options;
    Manifold& manifold;
    double rounding = rounding_of(a, b); ///< rounding of coordinates, metres

    const PlacedSurface& surface(int side) const { return side == 0 ? a : b; }
    bool solid() const { return a.solid() && b.solid(); }
    std::size_t most_points() const { return std::max(options.points_per_region, 1u); }
    /// How many regions a pair may have so that each can keep all its points.
    std::size_t most_regions() const
    {
        return std::max<std::size_t>(
            std::min<std::size_t>(options.regions_per_pair, options.points_per_pair / most_points()), 1);
    }
};

/// The decision of a pair; the one of the other order if only that is not separate: rounding can make them differ.
inline Finding decide_both_orders(PairWorker& worker, const PairTask& task)
{
    const Finding found = tests_for(task).decide(worker, task, {}, nullptr);
    if (found.verdict != Verdict::separate) return found;
    const PairTask back = task.swapped();
    const Finding other = tests_for(back).decide(worker, back, {}, nullptr);
    return other.verdict == Verdict::separate ? found : other;
}

} // namespace oncollide
