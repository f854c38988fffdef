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

/// True if the decision of a pair is that the bodies are apart, in both orders: rounding can make them differ.
inline bool decided_apart(PairWorker& worker, const PairTask& task)
{
    const auto apart = [&](const PairTask& pair) {
        return tests_for(pair).decide(worker, pair, {}, nullptr).verdict == Verdict::separate;
    };
    return apart(task) && apart(task.swapped());
}

} // namespace oncollide
