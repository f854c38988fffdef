#include <oncollide/narrowphase/rays/segment_tests.hpp>

#include <algorithm>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/shapes/cell_test.hpp>

namespace oncollide {

bool segment_meets(const Segment& segment, const TrianglePoints& t)
{
    const Eigen::Vector3d &p = segment.from, &q = segment.to;
    const int of_p = orient3d_filter(t[0], t[1], t[2], p), of_q = orient3d_filter(t[0], t[1], t[2], q);
    if (of_p * of_q > 0) return false;
    if (of_p * of_q < 0) { // it meets the plane at one point
        const int a = orient3d_filter(p, q, t[0], t[1]), b = orient3d_filter(p, q, t[1], t[2]),
                  c = orient3d_filter(p, q, t[2], t[0]);
        if (a * b < 0 || b * c < 0 || c * a < 0) return false;
        if (a && b && c) return true;
    }
    return triangles_meet({p, q, q}, t);
}

bool segment_meets(const Segment& segment, const Aabb& box)
{
    // Fractions of the segment at which it enters and leaves the slabs of the axes. A difference and a quotient err by
    // at most 3 u of a fraction, u = 2^-53, and keep its sign.
    constexpr double more = 1 + 0x1p-50, less = 1 - 0x1p-50;
    double enters = 0, leaves = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const double from = segment.from[axis], to = segment.to[axis], way = to - from;
        if (from == to) {
            if (from < box.min[axis] || from > box.max[axis]) return false;
            continue;
        }
        const double low = (box.min[axis] - from) / way, high = (box.max[axis] - from) / way;
        enters = std::max(enters, std::min(low, high)), leaves = std::min(leaves, std::max(low, high));
    }
    if (leaves < 0 || enters * less > leaves * more) return false;
    if (enters * more < leaves * less && leaves > 0x1p-900) return true;
    return cell_meets(box, {segment.from, segment.to, segment.to});
}

} // namespace oncollide
