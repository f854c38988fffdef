#pragma once
#include <oncollide/narrowphase/shapes/least_translation.hpp>

namespace oncollide {

/// The least translation of two cores that are boxes, segments or points, by separating axes; without their radii.
/// Edges that are parallel to 1e-8 have no axis of their own, which costs `lower` as much of the sizes.
LeastTranslation translation_of_boxes(const ConvexDifference& cores, double rounding, double cutoff);

} // namespace oncollide
