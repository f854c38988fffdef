#include <oncollide/narrowphase/pairs/manifolds/shapes/box_points.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <oncollide/narrowphase/pairs/manifolds/points/feature_bits.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// A face of a box, across `axis` on the high or the low side. Its sides are at high u, high v, low u and low v, in
/// this order. Corner k is between side k and the next side.
struct BoxFace {
    int axis;
    bool high;
    int u = (axis + 1) % 3, v = (axis + 2) % 3;

    FeatureBits face() const { return face_feature(static_cast<std::uint64_t>(4 * (2 - axis) + 2 * int{high})); }
    static bool is_high_u(int corner) { return corner == 0 || corner == 3; }
    static bool is_high_v(int corner) { return corner < 2; }
    std::uint32_t number(int corner) const // as in box_corners.hpp
    {
        return unsigned{high} << axis | unsigned{is_high_u(corner)} << u | unsigned{is_high_v(corner)} << v;
    }
    FeatureBits corner(int k) const { return vertex_feature(number(k)); }
    FeatureBits side(int k) const { return edge_feature(number((k + 3) % 4), number(k)); }
};

/// A corner of the common part: over the point (x, y) of the lower face along the normal, z above it. A number >= 0 is
/// the side of the upper face, -1 - k the cut by side k of the lower one.
struct CutCorner {
    double x, y, z;
    int before, after; ///< the sides that meet here
};

/// The corners of a quadrilateral that is cut by four lines.
class CutFace {
public:
    void add(const CutCorner& corner) { lists_[now_][count_++] = corner; }
    std::span<const CutCorner> corners() const { return std::span(lists_[now_]).first(count_); }

    /// Keeps the part up to `most` along the outward direction of a side: x, y, -x or -y.
    void cut(int side, double most, double slack)
    {
        const auto above = [&](const CutCorner& d) {
            const double along = side & 1 ? d.y : d.x;
            return (side & 2 ? -along : along) - most;
        };
        const auto& from = lists_[now_];
        std::array<double, room> height;
        bool any = false;
        for (std::uint32_t i = 0; i < count_; ++i) height[i] = above(from[i]), any |= height[i] > slack;
        if (!any) return;
        auto& to = lists_[1 - now_];
        std::uint32_t kept = 0;
        const auto add = [&](const CutCorner& corner) {
            if (kept < room) to[kept++] = corner;
        };
        for (std::uint32_t i = 0; i < count_; ++i) {
            const std::uint32_t j = i + 1 < count_ ? i + 1 : 0;
            const bool in = height[i] <= slack, next_in = height[j] <= slack;
            if (in) add(from[i]);
            if (in == next_in) continue;
            const double t = std::clamp(height[i] / (height[i] - height[j]), 0.0, 1.0);
            const CutCorner &p = from[i], &q = from[j];
            add({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y), p.z + t * (q.z - p.z), in ? p.after : -1 - side,
                 in ? -1 - side : p.after});
        }
        now_ = 1 - now_, count_ = kept;
    }

private:
    static constexpr std::uint32_t room = 12; ///< a cut adds one corner to four, or more by rounding
    std::array<CutCorner, room> lists_[2];
    std::uint32_t count_ = 0;
    int now_ = 0;
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
    CutFace cut;
    for (int k = 0; k < 4; ++k) {
        const Vector3d at =
            centre + (BoxFace::is_high_u(k) ? u : Vector3d(-u)) + (BoxFace::is_high_v(k) ? v : Vector3d(-v));
        const double height = up * at[axis] - half[axis];
        cut.add({at[flat.u] - height * way[flat.u], at[flat.v] - height * way[flat.v], height, k, (k + 1) % 4});
    }
    for (int side = 0; side < 4; ++side) cut.cut(side, half[side % 2 ? flat.v : flat.u], rounding);

    // In A's frame. Vectors by whole columns: numbers that are stored one by one are slow to load together.
    const auto in_a = [&](int k) { return of_a ? Vector3d(Vector3d::Unit(k)) : Vector3d(b_to_a.rotation.col(k)); };
    const Vector3d along_u = in_a(flat.u), along_v = in_a(flat.v),
                   on_face = (of_a ? a.centre : b_to_a(b.centre)) + up * half[axis] * in_a(axis);
    const Vector3d outward = r.col(across);
    const auto side_of = [](int cut_by) { return -1 - cut_by; };
    for (const CutCorner& d : cut.corners()) {
        double x = d.x, y = d.y, height = d.z;
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
