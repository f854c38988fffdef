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
    define(
        m, "sphere",
        [](py::handle radius, py::handle name) {
            return shape("sphere", Sphere{number(radius, {"sphere", "radius"})}, name);
        },
        "A solid sphere around the origin. radius: metres, > 0.", "radius"_a, unnamed);
    define(
        m, "box",
        [](py::handle half, py::handle name) {
            return shape("box", Box{vector3(half, {"box", "half_extents"})}, name);
        },
        "A solid box around the origin. half_extents: (3,) metres, half of each side, > 0.", "half_extents"_a, unnamed);
    const auto along_z = [&](const char* call, auto make, const char* text) {
        define(
            m, call,
            [call, make](py::handle radius, py::handle length, py::handle name) {
                return shape(call, make(number(radius, {call, "radius"}), number(length, {call, "length"})), name);
            },
            text, "radius"_a, "length"_a, unnamed);
    };
    along_z(
        "capsule",
        [](double r, double l) {
            return Shape(Capsule{r, l});
        },
        R"(A solid capsule along z, centred at the origin. radius: metres, > 0. length: of the cylinder, without the caps, >= 0.)");
    along_z(
        "cylinder",
        [](double r, double l) {
            return Shape(Cylinder{r, l});
        },
        R"(A solid cylinder along z, centred at the origin. radius, length: metres, > 0.)");
    along_z(
        "cone",
        [](double r, double l) {
            return Shape(Cone{r, l});
        },
        R"(A solid cone along z: the base at z = -length / 2, the apex at length / 2. radius, length: metres, > 0.)");
    define(
        m, "ellipsoid",
        [](py::handle semi_axes, py::handle name) {
            return shape("ellipsoid", Ellipsoid{vector3(semi_axes, {"ellipsoid", "semi_axes"})}, name);
        },
        "A solid ellipsoid around the origin. semi_axes: (3,) metres along x, y and z, > 0.", "semi_axes"_a, unnamed);
    define(
        m, "convex_hull",
        [](py::handle corners, py::handle name) {
            return shape("convex_hull", ConvexHull{points(corners, {"convex_hull", "points"})}, name);
        },
        "The solid convex hull of points: (N, 3) metres, at least four, not in one plane.", "points"_a, unnamed);
    define(
        m, "half_space", [](py::handle name) { return shape("half_space", HalfSpace{}, name); },
        "All points with z <= 0 in its own frame: an infinite floor.", unnamed);
}

} // namespace oncollide::python
