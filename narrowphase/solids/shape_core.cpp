#include <oncollide/narrowphase/solids/shape_core.hpp>

#include <oncollide/narrowphase/solids/convex_surface.hpp>
#include <oncollide/scenes/model/mesh_generators.hpp>
#include <oncollide/scenes/model/surface_grid.hpp>

namespace oncollide {

namespace {

/// Its corners are on a circle of this radius.
Mesh prism(double radius, double half, int sides)
{
    GridBuilder grid(sides, 1, false);
    grid.build(0, [&](double u, double v) -> Eigen::Vector3d {
        const Circle turn = circle(u / sides);
        return {radius * turn.cosine, radius * turn.sine, v > 0 ? half : -half};
    });
    const auto bottom = static_cast<std::uint32_t>(grid.points.size()), top = bottom + 1;
    grid.points.push_back({0, 0, -half}), grid.points.push_back({0, 0, half});
    for (int i = 0; i < sides; ++i) {
        grid.triangles.push_back({bottom, grid.at(i + 1, 0), grid.at(i, 0)});
        grid.triangles.push_back({top, grid.at(i, 1), grid.at(i + 1, 1)});
    }
    return make_mesh("cylinder", std::move(grid.points), std::move(grid.triangles));
}

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
        return {prism(within, half, sides), 0, prism(c.radius / cosine * (1 + slack), half, sides),
                (c.radius - within * cosine) * (1 + slack) + slack * c.radius};
    }
    ShapeCore operator()(const ConvexHull& h) const
    {
        return {make_mesh("convex hull", h.points, convex_surface(h.points)), 0, {}, 0};
    }
};

} // namespace

ShapeCore core_of(const Shape& shape)
{
    return std::visit(Core{}, shape);
}

} // namespace oncollide
