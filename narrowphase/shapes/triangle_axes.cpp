#include <oncollide/narrowphase/shapes/triangle_axes.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// Sine. An edge of the triangle that is nearer to an axis of the box has no normal with it.
constexpr double parallel_to_axis = 1e-8;

/// The axes of the box, relative to its middle.
class TriangleAndBox {
public:
    TriangleAndBox(const ConvexDifference& cores, double rounding, double cutoff)
        : cores_(cores), half_(0.5 * (cores.b().high - cores.b().low)),
          middle_(cores.b_to_a()(0.5 * (cores.b().low + cores.b().high))), rounding_(rounding), cutoff_(cutoff)
    {
        for (int k = 0; k < 3; ++k) corner_[k] = cores.into_b(cores.a().points[k] - middle_);
        for (int k = 0; k < 3; ++k) edge_[k] = corner_[(k + 1) % 3] - corner_[k];
        const double longest = std::max({edge_[0].norm(), edge_[1].norm(), edge_[2].norm()});
        size_ = longest + half_.norm();
    }
    LeastTranslation find();

private:
    /// A direction from the triangle to the box, and how far the box must move along it.
    struct Axis {
        double depth = std::numeric_limits<double>::infinity(), doubt = 0;
        Vector3d normal = Vector3d::Zero();
        int edge = -1, of_box = -1; ///< the edge of the triangle, the axis of the box; -1: none
    };
    /// Takes a unit direction or its opposite. False: the two are certainly farther apart than the cutoff.
    bool take(const Vector3d& n, double doubt, int edge, int of_box, Axis& best)
    {
        const double along[] = {n.dot(corner_[0]), n.dot(corner_[1]), n.dot(corner_[2])};
        const double width = half_.dot(n.cwiseAbs());
        const double up = width + std::max({along[0], along[1], along[2]}),
                     down = width - std::min({along[0], along[1], along[2]});
        const double depth = std::min(up, down);
        if (depth + doubt < -cutoff_) {
            beyond_ = depth + doubt;
            return false;
        }
        least_ = std::min(least_, depth - doubt);
        if (depth < best.depth) best = {depth, doubt, up <= down ? n : Vector3d(-n), edge, of_box};
        return true;
    }
    bool try_all(Axis& flat, Axis& face, Axis& edges);
    void set_points(LeastTranslation& found, const Axis& axis, const Vector3d& n) const;

    const ConvexDifference& cores_;
    const Vector3d half_, middle_;
    const double rounding_, cutoff_;
    double size_;
    std::array<Vector3d, 3> corner_, edge_;
    double least_ = std::numeric_limits<double>::infinity(), beyond_ = 0;
};

bool TriangleAndBox::try_all(Axis& flat, Axis& face, Axis& edges)
{
    const Vector3d across = edge_[0].cross(edge_[1]);
    const double area = across.norm(), longest = size_ - half_.norm();
    // The normal of a sliver errs by the corners' rounding over its height.
    if (area > 0 && !take(across / area, rounding_ * (2 + 4 * size_ * longest / area), -1, -1, flat)) return false;
    for (int i = 0; i < 3; ++i)
        if (!take(Vector3d::Unit(i), rounding_, -1, i, face)) return false;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            const Vector3d n = Vector3d::Unit(i).cross(edge_[k]);
            const double length = n.norm();
            if (!(length > parallel_to_axis * longest)) {
                if (longest > 0) least_ -= 2 * length / longest * size_;
                continue;
            }
            if (!take(n / length, rounding_ * (2 + 4 * size_ / length), k, i, edges)) return false;
        }
    return true;
}

/// @param n  the axis' normal, in the frame of the box
void TriangleAndBox::set_points(LeastTranslation& found, const Axis& axis, const Vector3d& n) const
{
    Vector3d on_a = Vector3d::Zero(), on_b = Vector3d::Zero();
    if (axis.edge < 0) { // the middle of the corners that are deepest in the face
        const double top = std::max({n.dot(corner_[0]), n.dot(corner_[1]), n.dot(corner_[2])});
        int count = 0;
        for (const Vector3d& p : corner_)
            if (n.dot(p) >= top - 0x1p-30 * size_) on_a += p, ++count;
        on_a /= count;
    } else { // where the two edges are nearest
        const Vector3d p = corner_[axis.edge], e = edge_[axis.edge];
        Vector3d q = (n.array() < 0).select(half_, -half_);
        q[axis.of_box] = 0;
        const Vector3d way = q - p, across = e - e[axis.of_box] * Vector3d::Unit(axis.of_box);
        on_a = p + std::clamp(way.dot(across) / across.squaredNorm(), 0.0, 1.0) * e;
    }
    on_b = (on_a - axis.depth * n).cwiseMax(-half_).cwiseMin(half_);
    const auto placed = [&](const Vector3d& p) { return Vector3d(cores_.b_to_a().rotation * p + middle_); };
    found.on_a = placed(on_a), found.on_b = placed(on_b), found.has_points = true;
}

LeastTranslation TriangleAndBox::find()
{
    LeastTranslation found{};
    Axis flat, face, edges;
    if (!try_all(flat, face, edges)) {
        found.beyond = true, found.upper = beyond_;
        return found;
    }
    const double smaller = std::min(size_ - half_.norm(), half_.norm());
    const auto better = [&](const Axis& a, const Axis& b) { // beyond the preference for a face
        return a.depth + face_preference(a.depth, smaller) < b.depth;
    };
    const Axis* best = better(face, flat) ? &face : &flat;
    if (better(edges, *best)) best = &edges;
    if (best != &flat) set_points(found, *best, best->normal);
    found.normal = (cores_.b_to_a().rotation * best->normal).normalized();
    found.upper = best->depth + best->doubt, found.lower = std::min(least_, found.upper);
    found.normal_error = std::min(std::numbers::pi, best->doubt / size_ + 8 * cores_.slack());
    found.of_axes = true;
    return found;
}

} // namespace

bool are_triangle_and_box(const ConvexDifference& cores)
{
    const Convex &a = cores.a(), &b = cores.b();
    return is_triangle(a) && b.core == Convex::Core::box && b.inner > 0 && a.radius == 0 && b.radius == 0;
}

LeastTranslation translation_of_triangle_and_box(const ConvexDifference& cores, double rounding, double cutoff)
{
    return TriangleAndBox(cores, rounding, cutoff).find();
}

} // namespace oncollide
