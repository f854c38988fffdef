#include <oncollide/narrowphase/solids/half_space.hpp>

#include <algorithm>
#include <array>
#include <limits>

#include <oncollide/scenes/model/box_corners.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// The lowest of the corners that corners_of(primitive, take) hands to take(), as placed; or the first that is no
/// higher than `enough`.
template <BoxHierarchy Hierarchy, class CornersOf>
class Lowest {
public:
    Lowest(Hierarchy& tree, const RelativePose& to_plane, double enough, CornersOf corners_of)
        : tree_(tree), to_plane_(to_plane), enough_(enough), corners_of_(corners_of),
          base_(to_plane(tree.centre()).z()),
          rounding_(0x1p-17 * tree.radius() + 0x1p-48 * (tree.centre().norm() + to_plane.translation.norm()))
    {
        descend(Hierarchy::root);
    }
    const Vector3d& point() const { return lowest_; }

private:
    void descend(const typename Hierarchy::Node& node)
    {
        OpenBoxes boxes;
        const LaneMasks masks = tree_.open(node, nullptr, boxes);
        std::array<std::pair<double, unsigned>, 8> lanes;
        unsigned count = 0;
        for (unsigned k = 0; k < 8; ++k)
            if (boxes.c[0][k] < 1e29f) lanes[count++] = {low(boxes, k), k}; // others hold no box
        std::sort(lanes.begin(), lanes.begin() + count);
        for (unsigned i = 0; i < count; ++i) {
            const auto [low, k] = lanes[i];
            if (low > lowest_.z() || lowest_.z() <= enough_) return;
            if (!(masks.leaves >> k & 1))
                descend(tree_.child(node, k));
            else
                for (const auto primitive : tree_.primitives(node, k)) corners_of_(primitive, *this);
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

public:
    void operator()(const Vector3d& corner)
    {
        const Vector3d p = to_plane_(corner);
        if (p.z() < lowest_.z()) lowest_ = p;
    }

private:
    Hierarchy& tree_;
    const RelativePose& to_plane_;
    const double enough_;
    CornersOf corners_of_;
    const double base_, rounding_;
    Vector3d lowest_ = Vector3d::Constant(std::numeric_limits<double>::infinity());
};

Vector3d lowest_of_shape(const Convex& c, const RelativePose& to_plane)
{
    if (!c.flat_sided) return to_plane(c.support(-to_plane.rotation.row(2).transpose()));
    Vector3d lowest = Vector3d::Constant(std::numeric_limits<double>::infinity());
    const auto take = [&](const Vector3d& corner) {
        const Vector3d p = to_plane(corner);
        if (p.z() < lowest.z()) lowest = p;
    };
    if (c.core == Convex::Core::points)
        for (std::uint32_t i = 0; i < c.count; ++i) take(c.points[i]);
    else
        for (unsigned k = 0; k < 8; ++k) take(corner_of({c.low, c.high}, k));
    return lowest;
}

double radius_of(const Model& body)
{
    return body.shape() ? body.convex().radius : 0;
}

} // namespace

HalfSpacePair::HalfSpacePair(Model& body, const RelativePose& body_to_plane, double slack)
    : body_(body), to_plane_(body_to_plane), slack_(slack)
{
}

Vector3d HalfSpacePair::lowest(double enough) const
{
    if (body_.is_half_space()) {
        // Unless their planes are parallel and they look away from each other, they meet somewhere.
        const Vector3d normal = to_plane_.rotation.col(2);
        if (normal.x() == 0 && normal.y() == 0 && normal.z() < 0) return to_plane_.translation;
        return Vector3d::Zero();
    }
    if (body_.shape()) return lowest_of_shape(body_.convex(), to_plane_);
    if (body_.map()) {
        MapTree& cells = body_.cells();
        return Lowest(cells, to_plane_, enough,
                      [&](const MapCell& cell, auto& take) {
                          for (unsigned k = 0; k < 8; ++k) take(corner_of(cells.map().box(cell), k));
                      })
            .point();
    }
    if (body_.terrain()) {
        TerrainTree& heights = body_.heights();
        return Lowest(heights, to_plane_, enough,
                      [&](std::uint32_t triangle, auto& take) {
                          for (const Vector3d& p : heights.points(triangle)) take(p);
                      })
            .point();
    }
    const Mesh& mesh = *body_.mesh();
    return Lowest(*body_.boxes, to_plane_, enough,
                  [&](std::uint32_t triangle, auto& take) {
                      for (std::uint32_t v : mesh.triangles[triangle]) take(mesh.vertices[v]);
                  })
        .point();
}

double HalfSpacePair::rounding() const
{
    if (body_.terrain()) return body_.terrain()->error();
    if (!body_.shape() || body_.is_half_space()) return 0;
    const Convex& c = body_.convex();
    if (c.flat_sided) return slack_ * c.radius;
    return (slack_ + 0x1p-47) * c.extent + 0x1p-47 * to_plane_.translation.norm();
}

ConvexMeeting HalfSpacePair::meeting() const
{
    const double radius = radius_of(body_), doubt = rounding(), height = lowest(radius - doubt).z();
    if (height <= radius - doubt) return {-1, 0};
    if (height > radius + doubt) return {1, (height - radius - doubt) * (1 - 0x1p-50)};
    return {0, std::max(height - radius, 0.0) + doubt};
}

ConvexDistance HalfSpacePair::distance() const
{
    const double radius = radius_of(body_), doubt = rounding() + 0x1p-50 * radius;
    const Vector3d p = lowest(radius - doubt);
    ConvexDistance d{0, 0, {p.x(), p.y(), 0}, {p.x(), p.y(), p.z() - radius}};
    if (p.z() <= radius - doubt) {
        d.on_b = d.on_a = {p.x(), p.y(), std::min(d.on_b.z(), 0.0)};
        return d;
    }
    d.lower = std::max(p.z() - radius - doubt, 0.0) * (1 - 0x1p-50);
    d.upper = (std::max(p.z() - radius, 0.0) + doubt) * (1 + 0x1p-50);
    return d;
}

} // namespace oncollide
