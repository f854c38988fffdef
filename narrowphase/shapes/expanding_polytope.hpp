#pragma once
#include <oncollide/narrowphase/shapes/least_translation.hpp>

namespace oncollide {

/// The least translation of two cores of which at least one has a volume, by an expanding polytope; without their
/// radii. Cores that are apart get the plane of a face that parts them.
/// @param rounding  error bound of a point of the difference
LeastTranslation translation_by_polytope(const ConvexDifference& cores, double rounding, double cutoff);

} // namespace oncollide
