#include <oncollide/narrowphase/pairs/manifolds/shapes/box_points.hpp>

#include <bit>

#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/feature_bits.hpp>
#include <oncollide/narrowphase/pairs/manifolds/shapes/face_over_face_kernel.hpp>

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
    static FindCommonCorners* const find_corners = ONCOLLIDE_CHOOSE_TO_AVX2(find_common_corners);
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
    const Vector3d in_a = b_to_a(b.centre) - a.centre,
                   middle = of_a ? in_a : Vector3d(-(b_to_a.rotation.transpose() * in_a));
    const Vector3d half = 0.5 * (low.high - low.low), size = 0.5 * (over.high - over.low);
    const double up = flat.high ? 1 : -1;
    // Moved along the normal into the plane: by this for each metre up.
    const double way_u = n[flat.u] / (up * n[axis]), way_v = n[flat.v] / (up * n[axis]);
    FaceOverFace faces;
    const auto lay = [&](double x, double y, double z, double(&to)[4]) {
        to[0] = x - z * way_u, to[1] = y - z * way_v, to[2] = z;
    };
    const auto axis_of = [&](int k, double length, double(&to)[4]) { // of the upper box, in low's frame
        const auto along = [&](int i) { return length * (of_a ? b_to_a.rotation(i, k) : b_to_a.rotation(k, i)); };
        lay(along(flat.u), along(flat.v), up * along(axis), to);
    };
    double out[4];
    axis_of(face.u, size[face.u], faces.u), axis_of(face.v, size[face.v], faces.v);
    axis_of(across, face.high ? size[across] : -size[across], out);
    lay(middle[flat.u], middle[flat.v], up * middle[axis] - half[axis], faces.middle);
    for (int k = 0; k < 3; ++k) faces.middle[k] += out[k];
    faces.half_x = half[flat.u], faces.half_y = half[flat.v], faces.rounding = rounding;
    CommonCorners corners;
    find_corners(faces, corners);

    // In A's frame. Vectors by whole columns: numbers that are stored one by one are slow to load together.
    const auto axis_in_a = [&](int k) { return of_a ? Vector3d(Vector3d::Unit(k)) : Vector3d(b_to_a.rotation.col(k)); };
    const Vector3d along_u = axis_in_a(flat.u), along_v = axis_in_a(flat.v),
                   on_face = (of_a ? a.centre : b_to_a(b.centre)) + up * half[axis] * axis_in_a(axis);
    const auto crossed = [&](CommonCorners::Kind kind, int k) { // the lower face's side
        const bool enters = kind == CommonCorners::entering;
        return corners.through_x[kind] >> k & 1 ? (bool(corners.rises_x >> k & 1) == enters ? 2 : 0)
                                                : (bool(corners.rises_y >> k & 1) == enters ? 3 : 1);
    };
    for (unsigned left = corners.there; left; left &= left - 1) {
        const int bit = std::countr_zero(left), k = bit / 4;
        const auto kind = static_cast<CommonCorners::Kind>(bit % 4);
        FeatureBits of_flat = flat.face(), of_face = face.face();
        if (kind == CommonCorners::of_upper)
            of_face = face.corner(k);
        else if (kind == CommonCorners::of_lower)
            of_flat = flat.corner(k);
        else
            of_face = face.side(k), of_flat = flat.side(crossed(kind, k));
        const double depth = -corners.z[kind][k] / slope;
        const Vector3d on_flat = on_face + corners.x[kind][k] * along_u + corners.y[kind][k] * along_v;
        if (of_a)
            points.add({on_flat, on_flat - depth * normal, depth, 0, of_flat, of_face});
        else
            points.add({on_flat + depth * normal, on_flat, depth, 0, of_face, of_flat});
    }
    return true;
}

} // namespace oncollide
