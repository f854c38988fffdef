#include <oncollide/narrowphase/solids/shape_core.hpp>

#include <limits>

#include <oncollide/narrowphase/solids/convex_surface.hpp>
#include <oncollide/scenes/model/mesh_generators.hpp>
#include <oncollide/scenes/model/surface_grid.hpp>

namespace oncollide {

namespace {

constexpr auto not_yet = std::numeric_limits<std::uint32_t>::max();

struct Core {
    ShapeCore operator()(const Sphere& s) const
    {
        return {make_mesh("centre", {Eigen::Vector3d::Zero()}, {{0, 0, 0}}), s.radius, {}, 0};
    }
    ShapeCore operator()(const Box& b) const { return {make_box_mesh(b.half), 0, {}, 0}; }
    ShapeCore operator()(const Capsule& c) const
    {
        const Eigen::Vector3d end(0, 0, 0.5 * c.length);
        return {make_mesh("axis", {-end, end}, {{0, 1, 1}}), c.radius, {}, 0};
    }
    ShapeCore operator()(const Cylinder& c) const
    {
        constexpr int sides = 512;
        constexpr double slack = 1e-14; // far more than the corners' rounding
        const double within = c.radius * (1 - slack), half = 0.5 * c.length, cosine = circle(0.5 / sides).cosine;
        return {make_prism("cylinder", within, half, sides), 0,
                make_prism("cylinder", c.radius / cosine * (1 + slack), half, sides),
                (c.radius - within * cosine) * (1 + slack) + slack * c.radius};
    }
    ShapeCore operator()(const ConvexHull& h) const
    {
        std::vector<Triangle> faces = convex_surface(h.points);
        std::vector<Eigen::Vector3d> corners;
        std::vector<std::uint32_t> place(h.points.size(), not_yet);
        for (Triangle& face : faces)
            for (std::uint32_t& v : face) {
                if (place[v] == not_yet)
                    place[v] = static_cast<std::uint32_t>(corners.size()), corners.push_back(h.points[v]);
                v = place[v];
            }
        return {make_mesh("convex hull", std::move(corners), std::move(faces)), 0, {}, 0};
    }
};

} // namespace

ShapeCore core_of(const Shape& shape)
{
    return std::visit(Core{}, shape);
}

} // namespace oncollide
