// Two geometries at two poses, without a World.
#include <oncollide/pipeline/two_geometries.hpp>

#include "held_world.hpp"

namespace oncollide::python {

namespace {

/// query(a, pose_a, b, pose_b, options...), without the interpreter's lock.
template <class Query, class... Options>
auto of_two(const char* call, py::handle a, py::handle pose_a, py::handle b, py::handle pose_b, Query query,
            const Options&... options)
{
    const GeometryHandle first = geometry(a, {call, "a"}), second = geometry(b, {call, "b"});
    const Eigen::Isometry3d at_a = pose(pose_a, {call, "pose_a"}), at_b = pose(pose_b, {call, "pose_b"});
    const Released released;
    return query(first, at_a, second, at_b, options...);
}

} // namespace

void bind_two_geometries(py::module_& m)
{
    using namespace py::literals;
    define(
        m, "collide",
        [](py::handle a, py::handle pose_a, py::handle b, py::handle pose_b) {
            return scalar(
                of_two("collide", a, pose_a, b, pose_b, [](const auto&... of) { return oncollide::collide(of...); }));
        },
        R"(Whether two geometries at two poses collide, exactly; touching counts. Returns as pairs.decide().

This call and distance(), contacts() and penetration() build their trees anew; a World keeps them.)",
        "a"_a, "pose_a"_a, "b"_a, "pose_b"_a);
    define(
        m, "distance",
        [](py::handle a, py::handle pose_a, py::handle b, py::handle pose_b, py::handle tolerance, py::handle cutoff) {
            return scalar(of_two(
                "distance", a, pose_a, b, pose_b, [](const auto&... of) { return oncollide::distance(of...); },
                distance_options(tolerance, cutoff, "distance")));
        },
        "Certified bounds on the distance of two geometries at two poses, as pairs.distance().", "a"_a, "pose_a"_a,
        "b"_a, "pose_b"_a, "tolerance"_a = 0.0, "cutoff"_a = py::none());
    define(
        m, "contacts",
        [](py::handle a, py::handle pose_a, py::handle b, py::handle pose_b) {
            return array_of(
                of_two("contacts", a, pose_a, b, pose_b, [](const auto&... of) { return oncollide::contacts(of...); }));
        },
        "All pairs of parts of two geometries at two poses that meet, as pairs.contacts().", "a"_a, "pose_a"_a, "b"_a,
        "pose_b"_a);
    define(
        m, "penetration",
        [](py::handle a, py::handle pose_a, py::handle b, py::handle pose_b) {
            return scalar(of_two("penetration", a, pose_a, b, pose_b,
                                 [](const auto&... of) { return oncollide::penetration(of...); }));
        },
        "How deep two geometries at two poses penetrate each other, as pairs.penetration().", "a"_a, "pose_a"_a, "b"_a,
        "pose_b"_a);
}

} // namespace oncollide::python
