#include <oncollide/narrowphase/pairs/half_space.hpp>

#include <algorithm>
#include <array>
#include <span>

#include <oncollide/base/numbers/infinity.hpp>
#include <oncollide/scenes/model/box_corners.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

namespace oncollide {

namespace half_space { // named, because lambdas of exported templates refer to it

using Eigen::Vector3d;

/// The lowest corner, as placed.
class Lowest {
public:
    explicit Lowest(const RelativePose& to_plane) : to_plane_(to_plane) {}
    void take(const Vector3d& corner)
    {
        const Vector3d p = to_plane_(corner);
        if (p.z() < point_.z()) point_ = p;
    }
    const Vector3d& point() const { return point_; }

private:
    const RelativePose& to_plane_;
    Vector3d point_ = Vector3d::Constant(infinity);
};

} // namespace half_space

namespace {

using half_space::Lowest, Eigen::Vector3d;

/// Calls visit(primitive) for the primitives of a hierarchy that may be below cut(), lower boxes first.
template <BoxHierarchy Hierarchy, class Cut, class Visit>
class LowFirst {
public:
    LowFirst(Hierarchy& tree, const RelativePose& to_plane, Cut cut, Visit visit)
        : tree_(tree), to_plane_(to_plane), cut_(cut), visit_(visit), base_(to_plane(tree.centre()).z()),
          rounding_(0x1p-17 * tree.radius() + 0x1p-48 * (tree.centre().norm() + to_plane.translation.norm()))
    {
        descend(Hierarchy::root);
    }

private:
    void descend(const typename Hierarchy::Node& node)
    {
        OpenBoxes boxes;
        const LaneMasks masks = tree_.open(node, nullptr, boxes);
        std::array<std::pair<double, unsigned>, 8> lanes; // the lowest first
        unsigned count = 0;
        for (unsigned k = 0; k < 8; ++k) {
            if (!(boxes.c[0][k] < 1e29f)) continue; // an unused lane
            const std::pair lane(low(boxes, k), k);
            unsigned at = count++;
            for (; at > 0 && lane < lanes[at - 1]; --at) lanes[at] = lanes[at - 1];
            lanes[at] = lane;
        }
        for (unsigned i = 0; i < count; ++i) {
            const auto [low, k] = lanes[i];
            if (low > cut_()) return;
            if (!(masks.leaves >> k & 1))
                descend(tree_.child(node, k));
            else
                for (const auto primitive : tree_.primitives(node, k)) visit_(primitive);
        }
    }
    double low(const OpenBoxes& boxes, unsigned k) const
    {
        double height = base_ - rounding_;
        for (int i = 0; i < 3; ++i) height += to_plane_.rotation(2, i) * double(boxes.c[i][k]);
        for (int axis = 0; axis < 3; ++axis) {
            double along = 0;
            for (int i = 0; i < 3; ++i) along += to_plane_.rotation(2, i) * double(boxes.axis[axis][i][k]);
            height -= std::abs(along) * double(boxes.h[axis][k]);
        }
        return height;
    }

    Hierarchy& tree_;
    const RelativePose& to_plane_;
    Cut cut_;
    Visit visit_;
    const double base_, rounding_;
};

// Pass the corners of a primitive to take().
void each_corner(const MapTree& tree, const MapCell& cell, auto take)
{
    for (unsigned k = 0; k < 8; ++k) take(corner_of(MapAccess::box(tree.map(), cell), k));
}
void each_corner(const TerrainTree& tree, std::uint32_t triangle, auto take)
{
    for (const Vector3d& p : tree.points(triangle)) take(p);
}
void each_corner(const ObbTree& tree, std::uint32_t triangle, auto take)
{
    for (const Vector3d& p : tree.corners(triangle)) take(p);
}

Vector3d lowest_of_shape(const Convex& c, const RelativePose& to_plane)
{
    const Vector3d up = to_plane.rotation.row(2);
    // The lowest corner of a box minimises every product, rounding included: sums of larger products are not less.
    if (c.core != Convex::Core::points) return to_plane(c.support(-up));
    const Vector3d* lowest = c.points;
    double least = infinity;
    for (const Vector3d& p : std::span(c.points, c.count)) {
        const double height =
            up.x() * p.x() + (up.y() * p.y() + up.z() * p.z()) + to_plane.translation.z(); // as placed
        if (height < least) least = height, lowest = &p;
    }
    return to_plane(*lowest);
}

/// A point of two overlapping half-spaces, if doubles can express it: down along the bisector of their normals.
Vector3d shared_point(const RelativePose& to_plane)
{
    const Vector3d normal = to_plane.rotation.col(2), into = -(Vector3d::UnitZ() + normal).normalized();
    const double depth = normal.dot(to_plane.translation);
    const Vector3d point = depth >= 0 ? Vector3d(0, 0, 0) : Vector3d(depth / normal.dot(into) * into);
    return point.allFinite() ? point : Vector3d(0, 0, 0);
}

/// As HalfSpacePair::lowest(), for another half-space.
Vector3d lowest_of_plane(const RelativePose& to_plane)
{
    // They meet unless their planes are parallel and they face away from each other.
    const Vector3d normal = to_plane.rotation.col(2), along(normal.x(), normal.y(), 0);
    const double across = along.norm(), height = normal.dot(to_plane.translation);
    if (across == 0 && normal.z() < 0) return to_plane.translation;
    if (height >= 0) return Vector3d::Zero();
    return normal.z() > across ? Vector3d(0, 0, height / normal.z()) : Vector3d(height / across / across * along);
}

} // namespace

template <class Body>
HalfSpacePair<Body>::HalfSpacePair(Model& body, const RelativePose& body_to_plane, double slack)
    : body_(body), to_plane_(body_to_plane), slack_(slack)
{
}

template <class Body>
double HalfSpacePair<Body>::radius() const
{
    if constexpr (is_solid)
        return body_.convex().radius;
    else
        return 0;
}

template <class Body>
Vector3d HalfSpacePair<Body>::lowest(double enough) const
{
    if constexpr (is_plane) {
        return lowest_of_plane(to_plane_);
    } else if constexpr (is_solid) {
        return lowest_of_shape(body_.convex(), to_plane_);
    } else {
        auto& tree = Body::tree(body_);
        Lowest lowest(to_plane_);
        LowFirst(
            tree, to_plane_, [&] { return lowest.point().z() <= enough ? -infinity : lowest.point().z(); },
            [&](const auto& primitive) { each_corner(tree, primitive, [&](const Vector3d& p) { lowest.take(p); }); });
        return lowest.point();
    }
}

template <class Body>
void HalfSpacePair<Body>::each_meeting(FunctionRef<void(const BodyPart&, const Vector3d&)> found) const
{
    if constexpr (!is_plane && !is_solid) {
        auto& tree = Body::tree(body_);
        LowFirst(
            tree, to_plane_, [] { return 0.0; },
            [&](const auto& primitive) {
                Lowest lowest(to_plane_);
                each_corner(tree, primitive, [&](const Vector3d& p) { lowest.take(p); });
                if (lowest.point().z() <= 0) found(BodyPart(primitive), lowest.point());
            });
    }
}

template <class Body>
double HalfSpacePair<Body>::rounding() const
{
    if constexpr (is_plane) {
        return 0;
    } else if constexpr (is_solid) {
        const Convex& c = body_.convex();
        if (c.flat_sided) return slack_ * c.radius;
        return (slack_ + 0x1p-47) * c.extent + 0x1p-47 * to_plane_.translation.norm();
    } else {
        return Body::error(body_);
    }
}

template <class Body>
double HalfSpacePair<Body>::low() const
{
    if (is_plane || is_solid) return -infinity;
    const Aabb box = bounds_of(body_.geometry());
    const Vector3d centre = box.centre(), half = box.half_extent();
    const double rounding = 0x1p-48 * (centre.norm() + half.norm() + to_plane_.translation.norm());
    return to_plane_(centre).z() - to_plane_.rotation.row(2).cwiseAbs().dot(half) - rounding;
}

template <class Body>
ConvexMeeting HalfSpacePair<Body>::meeting() const
{
    if (const double sure = low() - rounding(); sure > 0) return {1, sure};
    const double radius = this->radius(), doubt = rounding(), height = lowest(radius - doubt).z();
    if (height <= radius - doubt) return {-1, 0};
    if (height > radius + doubt) return {1, (height - radius - doubt) * (1 - 0x1p-50)};
    return {0, std::max(height - radius, 0.0) + doubt};
}

template <class Body>
ConvexDistance HalfSpacePair<Body>::distance(double above) const
{
    if (const double sure = low() - rounding(); sure > above)
        return {sure, infinity, Vector3d::Zero(), Vector3d::Zero()};
    const double radius = this->radius(), doubt = rounding() + 0x1p-50 * radius;
    const Vector3d p = lowest(radius - doubt);
    ConvexDistance d{0, 0, {p.x(), p.y(), 0}, {p.x(), p.y(), p.z() - radius}};
    if (p.z() <= radius - doubt) {
        d.on_b = d.on_a = {p.x(), p.y(), std::min(d.on_b.z(), 0.0)};
        if (is_plane && p.isZero(0)) d.on_b = d.on_a = shared_point(to_plane_);
        return d;
    }
    d.lower = std::max(p.z() - radius - doubt, 0.0) * (1 - 0x1p-50);
    d.upper = (std::max(p.z() - radius, 0.0) + doubt) * (1 + 0x1p-50);
    return d;
}

template <class Body>
typename HalfSpacePair<Body>::Depth HalfSpacePair<Body>::depth() const
{
    if constexpr (is_plane) {
        const Vector3d normal = to_plane_.rotation.col(2);
        if (normal.head<2>().isZero(0) && normal.z() < 0) {
            const double depth = std::max(-to_plane_.translation.z(), 0.0);
            return {depth, depth, to_plane_.translation};
        }
        return {infinity, infinity, lowest_of_plane(to_plane_)};
    } else {
        if (low() - rounding() > 0) return {0, 0, Vector3d::Zero()};
        const double radius = this->radius(), doubt = rounding() + 0x1p-50 * radius;
        const Vector3d p = lowest(-infinity);
        const Aabb box = bounds_of(body_.geometry());
        const double size = box.diagonal() + box.centre().norm() + to_plane_.translation.norm();
        const double depth = radius - p.z(), off = doubt + (slack_ + 0x1p-47) * size;
        return {std::max(depth - off, 0.0), std::max(depth + off, 0.0), {p.x(), p.y(), p.z() - radius}};
    }
}

template class HalfSpacePair<operand::Cells>;
template class HalfSpacePair<operand::Heights>;
template class HalfSpacePair<operand::Triangles>;
template class HalfSpacePair<operand::Solid>;
template class HalfSpacePair<operand::Plane>;

} // namespace oncollide
