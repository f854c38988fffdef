#include <oncollide/narrowphase/pairs/manifolds/shapes/contact_face.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <oncollide/narrowphase/pairs/manifolds/points/feature_bits.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

void add(ContactFace& face, const Vector3d& corner, std::uint32_t number)
{
    face.corner[face.count] = corner, face.number[face.count++] = number;
}

/// Corners of a box have bit 0 set for the larger x, bit 1 for y, bit 2 for z, as in box_corners.hpp.
void find_face_of_box(const Convex& c, const Vector3d& along, ContactFace& face)
{
    int axis = 0;
    along.cwiseAbs().maxCoeff(&axis);
    const bool high = along[axis] >= 0;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    face.normal = Vector3d::Unit(axis) * (high ? 1.0 : -1.0);
    face.face = box_face_feature(axis, high);
    for (int k = 0; k < 4; ++k) {
        // (low, low), (high, low), (high, high), (low, high) in (u, v), which is counter-clockwise around +axis
        const int at = high ? k : 3 - k;
        const bool u_high = at == 1 || at == 2, v_high = at >= 2;
        Vector3d corner;
        corner[axis] = high ? c.high[axis] : c.low[axis];
        corner[u] = u_high ? c.high[u] : c.low[u], corner[v] = v_high ? c.high[v] : c.low[v];
        add(face, corner, unsigned{high} << axis | unsigned{u_high} << u | unsigned{v_high} << v);
    }
}

void find_face_of_hull(const Model& model, const Vector3d& along, ContactFace& face)
{
    const Convex& c = model.convex();
    const HullFaces& hull = model.hull_faces();
    std::uint32_t best = 0;
    double most = c.points[0].dot(along);
    for (std::uint32_t i = 1; i < c.count; ++i)
        if (const double here = c.points[i].dot(along); here > most) best = i, most = here;
    const HullFaces::Face* found = nullptr;
    double best_cosine = -2;
    for (const std::uint32_t f : hull.around(best)) {
        const HullFaces::Face& candidate = hull.faces()[f];
        if (const double cosine = candidate.normal.dot(along); cosine > best_cosine)
            best_cosine = cosine, found = &candidate;
    }
    if (!found) { // a corner of slivers alone
        face.face = vertex_feature(best);
        return add(face, c.points[best], best);
    }
    face.normal = found->normal, face.off = found->off, face.sharp = found->sharp,
    face.face = face_feature(found->triangle);
    const auto corners = hull.corners(*found);
    const std::size_t stride = (corners.size() + ContactFace::most - 1) / ContactFace::most;
    for (std::size_t i = 0; i < corners.size(); i += stride) add(face, c.points[corners[i]], corners[i]);
}

/// Eight points of a circle around z, counter-clockwise seen from +z; the first is the support point along a direction.
void add_rim(ContactFace& face, double radius, double z, const Vector3d& along, bool up)
{
    const double across = std::hypot(along.x(), along.y());
    const bool aside = across > 0x1p-30 * std::abs(along.z());
    const double x = aside ? along.x() / across : 1, y = aside ? along.y() / across : 0;
    constexpr double h = std::numbers::sqrt2 / 2;
    constexpr double cosine[] = {1, h, 0, -h, -1, -h, 0, h}, sine[] = {0, h, 1, h, 0, -h, -1, -h};
    face.normal = Vector3d(0, 0, up ? 1 : -1);
    for (unsigned k = 0; k < 8; ++k) {
        const unsigned i = up ? k : (8 - k) % 8;
        add(face, {radius * (x * cosine[i] - y * sine[i]), radius * (x * sine[i] + y * cosine[i]), z}, i);
    }
}

void find_face_of_cylinder(const Convex& c, const Vector3d& along, ContactFace& face)
{
    const double across = std::hypot(along.x(), along.y());
    if (std::abs(along.z()) >= across) {
        face.face |= along.z() < 0 ? 1 : 2;
        return add_rim(face, c.high.x(), along.z() < 0 ? -c.high.z() : c.high.z(), along, along.z() >= 0);
    }
    const double x = c.high.x() * along.x() / across, y = c.high.x() * along.y() / across;
    add(face, {x, y, -c.high.z()}, 0), add(face, {x, y, c.high.z()}, 1);
}

void find_face_of_cone(const Convex& c, const Vector3d& along, ContactFace& face)
{
    const double across = std::hypot(along.x(), along.y()), slope = std::hypot(c.high.x(), 2 * c.high.z());
    // The directions of the side's normal and of the base.
    const double to_side = (2 * c.high.z() * across + c.high.x() * along.z()) / slope, to_base = -along.z();
    if (to_base > to_side) {
        face.face |= 1;
        return add_rim(face, c.high.x(), -c.high.z(), along, false);
    }
    const double x = across > 0 ? along.x() / across : 1, y = across > 0 ? along.y() / across : 0;
    add(face, {c.high.x() * x, c.high.x() * y, -c.high.z()}, 0), add(face, {0, 0, c.high.z()}, 1);
}

} // namespace

FeatureBits ContactFace::vertex(std::uint32_t i) const
{
    return rounded ? face | FeatureBits{number[i]} << 8 : vertex_feature(number[i]);
}

FeatureBits ContactFace::edge(std::uint32_t i, std::uint32_t k) const
{
    if (!rounded) return edge_feature(number[i], number[k]);
    const auto [from, to] = std::minmax(number[i], number[k]);
    return face | FeatureBits{from + 1} << 8 | FeatureBits{to + 1} << 16;
}

void ContactFace::place(const RelativePose& b_to_a)
{
    for (std::uint32_t i = 0; i < count; ++i) corner[i] = b_to_a(corner[i]);
    normal = b_to_a.rotation * normal;
}

void find_face(const Model& model, const Vector3d& along, ContactFace& face)
{
    const Convex& c = model.convex();
    face.count = 0, face.off = 0, face.sharp = 1, face.face = face_feature(0), face.rounded = true,
    face.normal.setZero();
    switch (c.core) {
    case Convex::Core::box:
        if (c.radius == 0) {
            face.rounded = false;
            return find_face_of_box(c, along, face);
        }
        add(face, c.low, 0);
        if (c.low != c.high) add(face, c.high, 1);
        return;
    case Convex::Core::points:
        face.rounded = false;
        return find_face_of_hull(model, along, face);
    case Convex::Core::cylinder:
        return find_face_of_cylinder(c, along, face);
    case Convex::Core::cone:
        return find_face_of_cone(c, along, face);
    case Convex::Core::ellipsoid:
        return add(face, c.support(along), 0);
    }
}

} // namespace oncollide
