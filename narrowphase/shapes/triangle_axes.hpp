#pragma once
#include <oncollide/narrowphase/shapes/least_translation.hpp>

namespace oncollide {

inline bool is_triangle(const Convex& c)
{
    return c.core == Convex::Core::points && c.count == 3;
}

/// True if A is a triangle, and B a box with a volume.
bool are_triangle_and_box(const ConvexDifference& cores);

/// The least translation of a triangle and a box, by separating axes. It gives points for a box's face and for two
/// edges, but none for the triangle's own normal.
LeastTranslation translation_of_triangle_and_box(const ConvexDifference& cores, double rounding, double cutoff);

} // namespace oncollide
