#include <oncollide/narrowphase/solids/shape_core.hpp>

#include <oncollide/narrowphase/solids/convex_surface.hpp>
#include <oncollide/scenes/model/mesh_generators.hpp>
#include <oncollide/scenes/model/surface_grid.hpp>

namespace oncollide {

namespace {

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
        return {make_mesh("convex hull", h.points, convex_surface(h.points)), 0, {}, 0};
    }
};

} // namespace

ShapeCore core_of(const Shape& shape)
{
    return std::visit(Core{}, shape);
}

} // namespace oncollide
