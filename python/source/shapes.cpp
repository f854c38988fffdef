// Shapes, by their sizes.
#include "geometry.hpp"

namespace oncollide::python {

namespace {

GeometryHandle shape(const char* call, Shape made, py::handle name)
{
    std::string called = text(name, {call, "name"});
    check_shape(name_or(called, call), made);
    return share(std::move(called), std::move(made));
}

} // namespace

void bind_shapes(py::module_& m)
{
    using namespace py::literals;
    const auto unnamed = py::arg("name") = py::str("");
    m.def(
        "sphere",
        [](py::handle radius, py::handle name) {
            return shape("sphere", Sphere{number(radius, {"sphere", "radius"})}, name);
        },
        "radius"_a, unnamed, R"(sphere(radius, name="")
--

A solid sphere around the origin. radius: metres, > 0.)");
    m.def(
        "box",
        [](py::handle half, py::handle name) {
            return shape("box", Box{vector3(half, {"box", "half_extents"})}, name);
        },
        "half_extents"_a, unnamed, R"(box(half_extents, name="")
--

A solid box around the origin. half_extents: (3,) metres, half of each side, > 0.)");
    const auto along_z = [&](const char* call, auto make, const char* text) {
        m.def(
            call,
            [call, make](py::handle radius, py::handle length, py::handle name) {
                return shape(call, make(number(radius, {call, "radius"}), number(length, {call, "length"})), name);
            },
            "radius"_a, "length"_a, unnamed, text);
    };
    along_z(
        "capsule",
        [](double r, double l) {
            return Shape(Capsule{r, l});
        },
        R"(capsule(radius, length, name="")
--

A solid capsule along z, centred at the origin. radius: metres, > 0. length: of the cylinder, without the caps, >= 0.)");
    along_z(
        "cylinder",
        [](double r, double l) {
            return Shape(Cylinder{r, l});
        },
        R"(cylinder(radius, length, name="")
--

A solid cylinder along z, centred at the origin. radius, length: metres, > 0.)");
    along_z(
        "cone",
        [](double r, double l) {
            return Shape(Cone{r, l});
        },
        R"(cone(radius, length, name="")
--

A solid cone along z: the base at z = -length / 2, the apex at length / 2. radius, length: metres, > 0.)");
    m.def(
        "ellipsoid",
        [](py::handle semi_axes, py::handle name) {
            return shape("ellipsoid", Ellipsoid{vector3(semi_axes, {"ellipsoid", "semi_axes"})}, name);
        },
        "semi_axes"_a, unnamed, R"(ellipsoid(semi_axes, name="")
--

A solid ellipsoid around the origin. semi_axes: (3,) metres along x, y and z, > 0.)");
    m.def(
        "convex_hull",
        [](py::handle corners, py::handle name) {
            return shape("convex_hull", ConvexHull{points(corners, {"convex_hull", "points"})}, name);
        },
        "points"_a, unnamed, R"(convex_hull(points, name="")
--

The solid convex hull of points: (N, 3) metres, at least four, not in one plane.)");
    m.def(
        "half_space", [](py::handle name) { return shape("half_space", HalfSpace{}, name); }, unnamed,
        R"(half_space(name="")
--

All points with z <= 0 in its own frame: an infinite floor.)");
}

} // namespace oncollide::python
