#include <oncollide/narrowphase/pairs/manifolds/shapes/box_points.hpp>

#include <algorithm>

#include <oncollide/narrowphase/pairs/manifolds/points/feature_bits.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/cut_polygon.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// A face of a box, across `axis` on the high or the low side. Its sides are at high u, high v, low u and low v, in
/// this order. Corner k is between side k and the next side.
struct BoxFace {
    int axis;
    bool high;
    int u = (axis + 1) % 3, v = (axis + 2) % 3;

    FeatureBits face() const { return box_face_feature(axis, high); }
    static bool is_high_u(int corner) { return corner == 0 || corner == 3; }
    static bool is_high_v(int corner) { return corner < 2; }
    std::uint32_t number(int corner) const // as in box_corners.hpp
    {
        return unsigned{high} << axis | unsigned{is_high_u(corner)} << u | unsigned{is_high_v(corner)} << v;
    }
    FeatureBits corner(int k) const { return vertex_feature(number(k)); }
    FeatureBits side(int k) const { return edge_feature(number((k + 3) % 4), number(k)); }
};

} // namespace

bool find_box_points(const Convex& a, const Convex& b, const RelativePose& b_to_a, const Vector3d& normal, double least,
                     double rounding, FewPoints& points)
{
    const Vector3d normal_b = b_to_a.rotation.transpose() * normal;
    int axis_a = 0, axis_b = 0;
    const double over_a = normal.cwiseAbs().maxCoeff(&axis_a), over_b = normal_b.cwiseAbs().maxCoeff(&axis_b);
    const bool of_a = over_a + 0x1p-20 >= over_b;
    if ((of_a ? over_a : over_b) < least) return false;
    // `low` has the face, and the other box lies over it; in low's frame, from low's middle.
    const Convex &low = of_a ? a : b, &over = of_a ? b : a;
    const Vector3d &n = of_a ? normal : normal_b, &n_over = of_a ? normal_b : normal;
    const int axis = of_a ? axis_a : axis_b, across = of_a ? axis_b : axis_a;
    const double slope = of_a ? over_a : over_b;
    const BoxFace flat{axis, (n[axis] > 0) == of_a}, face{across, (n_over[across] < 0) == of_a};
    Eigen::Matrix3d r = b_to_a.rotation;
    Vector3d middle = b_to_a(b.centre) - a.centre;
    if (!of_a) {
        r.transposeInPlace();
        middle = -(r * middle);
    }
    const Vector3d half = 0.5 * (low.high - low.low), size = 0.5 * (over.high - over.low);
    const double up = flat.high ? 1 : -1;
    const Vector3d way = n / (up * n[axis]); // one metre up, along the normal
    const Vector3d centre = middle + (face.high ? size[across] : -size[across]) * r.col(across);
    const Vector3d u = size[face.u] * r.col(face.u), v = size[face.v] * r.col(face.v);
    // Corners over the points (x, y) of the lower face along the normal, z above it. A quadrilateral and four cuts have
    // at most eight.
    CutPolygon<12> polygon;
    for (int k = 0; k < 4; ++k) {
        const Vector3d at =
            centre + (BoxFace::is_high_u(k) ? u : Vector3d(-u)) + (BoxFace::is_high_v(k) ? v : Vector3d(-v));
        const double height = up * at[axis] - half[axis];
        polygon.add({{at[flat.u] - height * way[flat.u], at[flat.v] - height * way[flat.v], height}, k, (k + 1) % 4});
    }
    for (int side = 0; side < 4; ++side)
        polygon.cut(side, rounding, [&, along = side % 2, most = half[side % 2 ? flat.v : flat.u]](const Vector3d& at) {
            return (side < 2 ? at[along] : -at[along]) - most;
        });

    // In A's frame. Vectors by whole columns: numbers that are stored one by one are slow to load together.
    const auto in_a = [&](int k) { return of_a ? Vector3d(Vector3d::Unit(k)) : Vector3d(b_to_a.rotation.col(k)); };
    const Vector3d along_u = in_a(flat.u), along_v = in_a(flat.v),
                   on_face = (of_a ? a.centre : b_to_a(b.centre)) + up * half[axis] * in_a(axis);
    const Vector3d outward = r.col(across);
    const auto side_of = [](int cut_by) { return -1 - cut_by; };
    for (const auto& d : polygon.corners()) {
        double x = d.at.x(), y = d.at.y(), height = d.at.z();
        FeatureBits of_flat = flat.face(), of_face = face.face();
        if (d.before >= 0 && d.after >= 0) {
            of_face = face.corner(d.before);
        } else if (d.before < 0 && d.after < 0) {
            const int p = side_of(d.before), q = side_of(d.after), corner = (p + 1) % 4 == q ? p : q;
            if ((p + q) % 2 == 0) { // opposite sides meet in no corner
                of_flat = edge_feature(flat.number(p), flat.number(q));
            } else {
                of_flat = flat.corner(corner);
                x = BoxFace::is_high_u(corner) ? half[flat.u] : -half[flat.u];
                y = BoxFace::is_high_v(corner) ? half[flat.v] : -half[flat.v];
                height = (outward.dot(centre) - outward[flat.u] * x - outward[flat.v] * y -
                          outward[axis] * up * half[axis]) /
                         outward.dot(way);
            }
        } else {
            of_face = face.side(std::max(d.before, d.after)), of_flat = flat.side(side_of(std::min(d.before, d.after)));
        }
        const double depth = -height / slope;
        const Vector3d on_flat = on_face + x * along_u + y * along_v;
        if (of_a)
            points.add({on_flat, on_flat - depth * normal, depth, 0, of_flat, of_face});
        else
            points.add({on_flat + depth * normal, on_flat, depth, 0, of_face, of_flat});
    }
    return true;
}

} // namespace oncollide
