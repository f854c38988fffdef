#include <oncollide/narrowphase/rays/segment_tests.hpp>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>

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

} // namespace oncollide
