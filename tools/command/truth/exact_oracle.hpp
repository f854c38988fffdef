#pragma once
#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide::oracle {

/// The true contact of two triangles, also of segments, points and coplanar triangles. Cost: 10 to 100 microseconds;
/// 0.1 s if magnitudes are as far apart as doubles allow.
TriangleContact contact(const TrianglePoints& a, const TrianglePoints& b);

} // namespace oncollide::oracle
