// Robot: configurations of a robot against itself and the bodies of a World.
#include <algorithm>
#include <array>
#include <limits>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "geometry.hpp"
#include "held_robot.hpp"

namespace oncollide::python {

py::array rows_of(const HeldRobot& robot, py::handle value, const Place& place)
{
    py::array array = doubles(value, place);
    const auto width = static_cast<py::ssize_t>(robot.robot->width());
    if (!has_shape(array, {-1, width}) && !has_shape(array, {width}))
        refuse_value(place, fmt::format("expected shape (N, {}), got {}", width, shape_of(array)));
    return array;
}

std::span<const double> span_of(const py::array& array)
{
    return {static_cast<const double*>(array.data()), static_cast<std::size_t>(array.size())};
}

std::uint32_t link_of(const HeldRobot& robot, py::handle value, const Place& place)
{
    if (!py::isinstance<py::str>(value)) return static_cast<std::uint32_t>(whole(value, place, 0xffffffffu));
    const std::string name = text(value, place);
    const auto& links = robot.robot->description().links;
    const auto found = std::ranges::find(links, name, &RobotLink::name);
    if (found == links.end()) refuse_value(place, fmt::format("the robot has no link '{}'", name));
    return static_cast<std::uint32_t>(found - links.begin());
}

namespace {

std::unique_ptr<HeldRobot> make(HeldWorld& held, py::handle urdf, py::handle srdf, py::handle packages, py::handle base)
{
    const char* const call = "Robot";
    RobotReading reading;
    if (!srdf.is_none()) reading.srdf = path(srdf, {call, "srdf"});
    if (!packages.is_none()) {
        if (!py::isinstance<py::dict>(packages)) refuse_type({call, "packages"}, "a dict of folders by name", packages);
        for (const auto& [name, folder] : py::reinterpret_borrow<py::dict>(packages))
            reading.packages[text(name, {call, "packages"})] = path(folder, {call, "packages"});
    }
    const std::string file = path(urdf, {call, "urdf"});
    const Eigen::Isometry3d at = pose(base, {call, "base"});
    RobotDescription description = load_robot(file, reading);
    emit_file_warnings();
    const Inside inside(held, call);
    return std::make_unique<HeldRobot>(
        HeldRobot{held.shared_from_this(), std::make_unique<Robot>(held.world, std::move(description), at)});
}

std::size_t count_of(const py::array& rows)
{
    return rows.ndim() == 1 ? 1 : static_cast<std::size_t>(rows.shape(0));
}

/// Both ends of motions, of the same shape.
std::pair<py::array, py::array> ends_of(const HeldRobot& robot, py::handle from, py::handle to, const char* call)
{
    const py::array starts = rows_of(robot, from, {call, "start"}), ends = rows_of(robot, to, {call, "end"});
    if (starts.size() != ends.size())
        refuse_value({call, "end"}, fmt::format("expected shape {}, got {}", shape_of(starts), shape_of(ends)));
    return {starts, ends};
}

/// One result for one row, or an array.
template <class Result>
py::object results_of(const py::array& rows, std::vector<Result> found)
{
    if (rows.ndim() == 1) return scalar(found.front());
    return array_of(std::move(found));
}

py::object check(HeldRobot& robot, py::handle configurations, py::handle self, py::handle environment)
{
    const char* const call = "Robot.check";
    const py::array rows = rows_of(robot, configurations, {call, "configurations"});
    const RobotCheck what{.self = truth(self, {call, "self_collision"}),
                          .environment = truth(environment, {call, "environment"})};
    std::vector<RobotFinding> found(count_of(rows));
    {
        const Looking looking(*robot.held, call);
        const Released released;
        robot.robot->check(robot.held->world, span_of(rows), found, what);
    }
    return results_of(rows, std::move(found));
}

/// Poses of `each` bodies in each of many copies.
py::array poses_of_copies(py::handle value, std::size_t copies, std::size_t each, const Place& place)
{
    const py::array array = doubles(value, place);
    const auto n = static_cast<py::ssize_t>(copies), k = static_cast<py::ssize_t>(each);
    if (has_shape(array, {n, k, 7})) return array.attr("reshape")(n * k, 7);
    if (has_shape(array, {n, k, 4, 4})) return array.attr("reshape")(n * k, 4, 4);
    refuse_value(place, fmt::format("expected shape ({0}, {1}, 4, 4), or ({0}, {1}, 7) with x y z qx qy qz qw, got {2}",
                                    n, k, shape_of(array)));
}

py::object check_copies(HeldRobot& robot, py::handle bodies, py::handle poses, py::handle configurations,
                        py::handle self, py::handle environment)
{
    const char* const call = "Robot.check_copies";
    const py::array rows = rows_of(robot, configurations, {call, "configurations"});
    if (rows.ndim() == 1) refuse_value({call, "configurations"}, "expected one row for each copy");
    const std::size_t copies = count_of(rows), width = robot.robot->width();
    const Ids ids(bodies, {call, "bodies"});
    const Poses at(poses_of_copies(poses, copies, ids.size(), {call, "poses"}), {call, "poses"});
    const RobotCheck what{.self = truth(self, {call, "self_collision"}),
                          .environment = truth(environment, {call, "environment"})};
    std::vector<RobotFinding> found(copies);
    {
        const Looking looking(*robot.held, call);
        const Released released;
        constexpr std::size_t block = 4096; // of copies: their poses are converted at a time
        std::vector<Eigen::Isometry3d> placed;
        for (std::size_t first = 0; first < copies; first += block) {
            const std::size_t count = std::min(block, copies - first);
            placed.clear();
            for (std::size_t i = first * ids.size(); i < (first + count) * ids.size(); ++i) placed.push_back(at[i]);
            robot.robot->check(robot.held->world, {{ids.begin(), ids.size()}, placed},
                               span_of(rows).subspan(first * width, count * width),
                               std::span(found).subspan(first, count), what);
        }
    }
    return array_of(std::move(found));
}

py::tuple distances(HeldRobot& robot, py::handle configurations, py::handle cutoff, py::handle tolerance,
                    py::handle every_pair, py::handle gradients, py::handle depths, py::handle self,
                    py::handle environment)
{
    const char* const call = "Robot.distances";
    const py::array rows = rows_of(robot, configurations, {call, "configurations"});
    const RobotDistanceOptions options{.pairs = {.self = truth(self, {call, "self_collision"}),
                                                 .environment = truth(environment, {call, "environment"})},
                                       .tolerance = number(tolerance, {call, "tolerance"}),
                                       .cutoff = limit_of(cutoff, {call, "cutoff"}),
                                       .every_pair = truth(every_pair, {call, "every_pair"}),
                                       .gradients = truth(gradients, {call, "gradients"}),
                                       .depths = truth(depths, {call, "depths"})};
    RobotDistances found;
    {
        const Looking looking(*robot.held, call);
        const Released released;
        robot.robot->distances(robot.held->world, span_of(rows), found, options);
    }
    const std::array<py::ssize_t, 2> shape{options.gradients ? static_cast<py::ssize_t>(found.pairs.size()) : 0,
                                           static_cast<py::ssize_t>(robot.robot->width())};
    py::array_t<double> slopes(shape);
    std::ranges::copy(found.gradients, slopes.mutable_data());
    const py::array offsets = offsets_of(found.offsets);
    py::array pairs = array_of(std::move(found.pairs));
    return rows.ndim() == 1 ? py::make_tuple(pairs, slopes) : py::make_tuple(pairs, slopes, offsets);
}

py::object check_edges(HeldRobot& robot, py::handle from, py::handle to, py::handle tolerance, py::handle first,
                       py::handle self, py::handle environment)
{
    const char* const call = "Robot.check_edges";
    const auto [starts, ends] = ends_of(robot, from, to, call);
    const RobotEdgeCheck what{.pairs = {.self = truth(self, {call, "self_collision"}),
                                        .environment = truth(environment, {call, "environment"})},
                              .tolerance = number(tolerance, {call, "tolerance"}),
                              .first = truth(first, {call, "first"})};
    std::vector<RobotEdgeFinding> found(count_of(starts));
    {
        const Looking looking(*robot.held, call);
        const Released released;
        robot.robot->check_edges(robot.held->world, span_of(starts), span_of(ends), found, what);
    }
    return results_of(starts, std::move(found));
}

py::object edge_clearance(HeldRobot& robot, py::handle from, py::handle to, py::handle tolerance, py::handle self,
                          py::handle environment)
{
    const char* const call = "Robot.edge_clearance";
    const auto [starts, ends] = ends_of(robot, from, to, call);
    const RobotClearanceOptions options{.pairs = {.self = truth(self, {call, "self_collision"}),
                                                  .environment = truth(environment, {call, "environment"})},
                                        .tolerance = number(tolerance, {call, "tolerance"})};
    std::vector<RobotEdgeClearance> found(count_of(starts));
    {
        const Looking looking(*robot.held, call);
        const Released released;
        robot.robot->edge_clearance(robot.held->world, span_of(starts), span_of(ends), found, options);
    }
    return results_of(starts, std::move(found));
}

py::array array_of_numbers(const std::vector<double>& numbers)
{
    return py::array_t<double>(static_cast<py::ssize_t>(numbers.size()), numbers.data());
}

py::array state(HeldRobot& robot, py::handle name, py::handle group)
{
    std::vector<double> numbers = robot.robot->neutral();
    robot.robot->apply_state(text(name, {"Robot.state", "name"}),
                             group.is_none() ? "" : text(group, {"Robot.state", "group"}), numbers);
    return array_of_numbers(numbers);
}

py::array link_poses(HeldRobot& robot, py::handle configurations)
{
    const py::array rows = rows_of(robot, configurations, {"Robot.link_poses", "configuration"});
    const std::size_t width = robot.robot->width(), links = robot.robot->description().links.size();
    const std::size_t count = count_of(rows);
    std::vector<Eigen::Isometry3d> poses(links);
    std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(links), 4, 4};
    if (rows.ndim() == 2) shape.insert(shape.begin(), rows.shape(0));
    py::array_t<double> made(shape);
    double* at = made.mutable_data();
    for (std::size_t i = 0; i < count; ++i) {
        robot.robot->link_poses(span_of(rows).subspan(i * width, width), poses);
        for (const Eigen::Isometry3d& pose : poses) {
            Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(at);
            matrix = pose.matrix(), at += 16;
        }
    }
    return made;
}

py::array jacobian(HeldRobot& robot, py::handle configuration, py::handle link, py::handle point)
{
    const char* const call = "Robot.jacobian";
    const py::array row = rows_of(robot, configuration, {call, "configuration"});
    if (row.ndim() != 1) refuse_value({call, "configuration"}, "one configuration, not many");
    const std::size_t width = robot.robot->width();
    py::array_t<double> rows(std::array<py::ssize_t, 2>{6, static_cast<py::ssize_t>(width)});
    robot.robot->jacobian(span_of(row), link_of(robot, link, {call, "link"}), vector3(point, {call, "point"}),
                          {rows.mutable_data(), 6 * width});
    return rows;
}

/// The limits of each number.
py::array limits(const HeldRobot& robot)
{
    const std::vector<std::string>& names = robot.robot->names();
    constexpr double endless = std::numeric_limits<double>::infinity();
    py::array_t<double> made(std::array<py::ssize_t, 2>{static_cast<py::ssize_t>(names.size()), 2});
    for (std::size_t i = 0; i < names.size(); ++i) {
        const auto joint = std::ranges::find(robot.robot->description().joints, names[i], &RobotJoint::name);
        const bool has = joint != robot.robot->description().joints.end();
        double* const at = made.mutable_data(static_cast<py::ssize_t>(i), 0);
        at[0] = has ? joint->lower : -endless, at[1] = has ? joint->upper : endless;
    }
    return made;
}

py::list parents(const HeldRobot& robot)
{
    std::vector<std::int64_t> of(robot.robot->description().links.size(), -1);
    for (const RobotJoint& joint : robot.robot->description().joints) of[joint.child] = joint.parent;
    return py::cast(of);
}

} // namespace

void bind_robot(py::module_& m)
{
    using namespace py::literals;
    py::class_<HeldRobot> robot(m, "Robot", R"(Robot(world, urdf, srdf=None, packages=None, base=None)
--

A robot from a URDF file, whose links become models of the World; an SRDF file gives excluded pairs and states. MJCF is
read, too: its pairs and keyframes are MuJoCo's.

    world = oncollide.World(threads=0)
    robot = oncollide.Robot(world, "panda.urdf", srdf="panda.srdf")
    free = robot.check(samples)["verdict"] == oncollide.Verdict.SEPARATE

packages: folders by name, for meshes named package://NAME/...; by default they are found beside the file or above it.
base: pose of the root link. Raises Error that names the file and the line.)");
    refuse_pickles(robot, "Robot", "make it in each process, of its file, in a World there");
    robot.def(py::init(&make), "world"_a, "urdf"_a, "srdf"_a = py::none(), "packages"_a = py::none(),
              "base"_a = py::none());
    define(robot, "check", &check,
           R"(Tests a configuration, float64 (width,), or many, (N, width), with the World's accuracy and threads.

Structured: verdict (a Verdict), bound (metres), link, other (indices of `links`; -1: none) and body
(an id, if other is -1). The pair is the first that collides, or the one with the least bound. Not copied if
C-contiguous and float64. Other Python threads can run meanwhile. Raises ValueError for other shapes, Error naming the
configuration that is not finite.)",
           "configurations"_a, "self_collision"_a = true, "environment"_a = true);
    define(robot, "check_copies", &check_copies,
           R"(Tests configuration i in copy i of the World, in which `bodies` (K ids) have the poses poses[i], float64
(N, K, 4, 4) or (N, K, 7); all other bodies stay where they are. N copies need no more memory than their poses.

Returns N rows as check() does. Each is the result of a World with the bodies at these poses. Other Python threads can run
meanwhile. Raises ValueError for other shapes, Error for a pose that is not rigid, or a body that is listed twice.)",
           "bodies"_a, "poses"_a, "configurations"_a, "self_collision"_a = true, "environment"_a = true);
    define(
        robot, "distances", &distances,
        R"(The signed distance of a configuration, float64 (width,), or of many, (N, width), to its nearest pair; with
every_pair, of each pair at most `cutoff` metres apart (None: of all).

Returns (pairs, gradients), for many configurations (pairs, gradients, offsets); the nearest pair is first.
pairs, structured: lower, upper (certified bounds, metres; below 0 where they meet: minus the depth), link, other, body
(as in check()), point, other_point (float64 (3,), world), normal (from the link to the other) and unique (False: the
gradient is one of several). gradients: float64 (pairs, width), the derivatives of the distance by each number.
depths=False: pairs that meet have the distance 0 and a gradient of zeros, which is faster. Raises as check().)",
        "configurations"_a, "cutoff"_a = py::none(), "tolerance"_a = 0.0, "every_pair"_a = false, "gradients"_a = true,
        "depths"_a = true, "self_collision"_a = true, "environment"_a = true);
    define(
        robot, "check_edges", &check_edges,
        R"(Tests a whole motion between two configurations, float64 (width,), or many, (N, width): all joints move at constant speed, and
no contact between samples is missed.

Structured: clear_until (certified: the share of the motion, 0 to 1, before which there is no
contact), contact_by (a share at which there certainly is one; inf: none found), verdict (a Verdict), and link, other and
body as in check(). The first contact is found to `tolerance`, a share of the motion; first=False stops at any contact,
which is faster. Raises as check().)",
        "start"_a, "end"_a, "tolerance"_a = 1e-4, "first"_a = true, "self_collision"_a = true, "environment"_a = true);
    define(
        robot, "edge_clearance", &edge_clearance,
        R"(The least distance of all pairs on a whole motion between two configurations, float64 (width,), or on many, (N, width).

Structured: lower, upper (certified, at most `tolerance` metres apart; 0 where a pair meets), at (the share of the
motion), link, other and body as in check(). Raises as check().)",
        "start"_a, "end"_a, "tolerance"_a = 1e-3, "self_collision"_a = true, "environment"_a = true);
    define(
        robot, "state", &state,
        "A configuration, float64 (width,): the numbers of a state of the SRDF file; other joints are as in neutral().",
        "name"_a, "group"_a = py::none());
    define(
        robot, "neutral", [](const HeldRobot& held) { return array_of_numbers(held.robot->neutral()); },
        "The configuration with all numbers 0, or the nearest limit; float64 (width,).");
    define(robot, "link_poses", &link_poses,
           "The poses of all links in the world, float64 (links, 4, 4); for many configurations (N, links, 4, 4).",
           "configuration"_a);
    define(robot, "jacobian", &jacobian,
           "float64 (6, width): derivatives of the position of a point (metres, in the link's frame) and of the link's "
           "rotation by each number of the configuration. link: name or index.",
           "configuration"_a, "link"_a, "point"_a = py::make_tuple(0, 0, 0));
    bind_robot_setup(robot);
    robot.def_property_readonly("limits", &limits,
                                "The least and greatest value of each number, float64 (width, 2); infinite: no limit.");
    robot.def_property_readonly("parents", &parents,
                                "The parent of each link by its index (list of int); -1: the root.");
    robot.def_property_readonly(
        "joints",
        [](const HeldRobot& held) {
            py::list names;
            for (const std::string& name : held.robot->names()) names.append(name);
            return names;
        },
        "The name of each number of a configuration (list of str).");
    robot.def_property_readonly(
        "links",
        [](const HeldRobot& held) {
            py::list names;
            for (const RobotLink& link : held.robot->description().links) names.append(link.name);
            return names;
        },
        "The names of the links (list of str).");
}

} // namespace oncollide::python
