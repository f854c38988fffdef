// The columns `manifold` and `near_features` of the table of kinds (pair_tests.hpp).
#pragma once
#include <oncollide/narrowphase/pairs/pair_tests.hpp>

namespace oncollide {

/// Pairs::manifold() for every two kinds except two half-spaces.
void manifold_of(PairWorker& worker, const PairTask& task, const ManifoldOptions& options, Manifold& manifold);

/// True if manifold_of() needs the trees of the models that have triangles.
bool needs_trees(const PairTask& task);

/// True if one of two bodies whose surfaces do not meet may be inside the other, a closed mesh, or below it, a terrain:
/// then they have a region although they are apart in surface mode. Cost: some 0.1 microseconds.
bool may_be_enclosed(const PairTask& task);

/// Keeps at most this many points: regions share them in turn, the deepest first, and lose their last points.
void limit_points(Manifold& manifold, std::size_t most);
/// The same for the points of all manifolds: pairs share them in turn, the deepest first.
void limit_points(std::span<Manifold> manifolds, std::size_t most);

/// Pairs::near_features() for two bodies with triangles or heights.
void near_features_of(PairWorker& worker, const PairTask& task, double dhat, std::vector<NearFeatures>& found);

} // namespace oncollide
