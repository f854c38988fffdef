// oncollide-lab bench robot-distances: the least distance of a robot's configurations among bodies, with and without
// its gradient, and FCL's.
#include "bench/robot/robot_place.hpp"
#include "peers/fcl_robot.hpp"

#include <algorithm>
#include <cmath>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::tools {
namespace {

struct RobotDistanceBenchOptions : SharedOptions {
    RobotOptions robot;
    int bodies = 40, configurations = 1000, differences = 100;
    double cutoff = 0.05;
};

/// Boxes, cylinders, balls and meshes of 5 to 30 cm, from 0.5 to 1.5 m around the base.
std::vector<LinkGeometry> bodies_around(const RobotDistanceBenchOptions& options)
{
    std::vector<LinkGeometry> bodies;
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(options.bodies); ++i) {
        auto random = [&, k = std::uint64_t{0}](double low, double high) mutable {
            return low + (high - low) * u01(options.seed, i, k++);
        };
        const double size = random(0.05, 0.3), turn = random(0, 2 * M_PI), away = random(0.5, 1.5);
        GeometryData data = i % 4 == 0   ? GeometryData(Shape(Box{{0.5 * size, 0.5 * size, random(0.02, 0.3)}}))
                            : i % 4 == 1 ? GeometryData(Shape(Cylinder{0.3 * size, 2 * size}))
                            : i % 4 == 2
                                ? GeometryData(make_torus_knot_mesh(2, 3, 0.3 * size, 0.12 * size, 0.06 * size, 5000))
                                : GeometryData(Shape(Sphere{0.5 * size}));
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.linear() = Eigen::Quaterniond(random(-1, 1), random(-1, 1), random(-1, 1), random(-1, 1))
                            .normalized()
                            .toRotationMatrix();
        pose.translation() = Eigen::Vector3d(away * std::cos(turn), away * std::sin(turn), random(0, 1.3));
        bodies.push_back(
            {std::make_shared<const Geometry>(Geometry{fmt::format("body {}", i), std::move(data), {}}), pose});
    }
    return bodies;
}

std::vector<double> random_configurations(const RobotDistanceBenchOptions& options, const Robot& robot)
{
    std::vector<double> numbers;
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(options.configurations); ++i) {
        std::vector<double> at = robot.neutral();
        for (const RobotJoint& joint : robot.description().joints) {
            const auto number = std::ranges::find(robot.names(), joint.name);
            if (number == robot.names().end()) continue;
            const auto k = static_cast<std::size_t>(number - robot.names().begin());
            const double low = std::max(joint.lower, -M_PI), high = std::min(joint.upper, M_PI);
            at[k] = low + (high - low) * u01(options.seed + 1, i, k);
        }
        numbers.insert(numbers.end(), at.begin(), at.end());
    }
    return numbers;
}

/// Gradients against differences of distances, where the gradient is unique and the nearest features stay.
struct GradientErrors {
    std::size_t compared = 0;
    double most = 0; ///< of a component, as a share of the gradient
};

GradientErrors gradient_errors(const RobotPlace& place, std::span<const double> numbers, std::size_t count)
{
    constexpr double step = 1e-4; // rad or m
    const std::size_t width = place.robot.width();
    GradientErrors errors;
    RobotDistances found, moved;
    place.robot.distances(place.world, numbers.first(count * width), found);
    if (found.pairs.size() != count) return errors; // nothing to measure
    std::vector<double> around;
    for (std::size_t i = 0; i < count; ++i) {
        const RobotDistance& d = found.pairs[i];
        if (!d.unique || d.lower <= 10 * step) continue;
        around.clear();
        for (std::size_t k = 0; k < width; ++k)
            for (const double by : {-2 * step, -step, step, 2 * step}) {
                around.insert(around.end(), &numbers[i * width], &numbers[i * width] + width);
                around[around.size() - width + k] += by;
            }
        place.robot.distances(place.world, around, moved, {.gradients = false});
        const auto other_pair = [&](const RobotDistance& m) {
            return std::tuple(m.link, m.other, m.body) != std::tuple(d.link, d.other, d.body);
        };
        if (std::ranges::any_of(moved.pairs, other_pair)) continue;
        const Eigen::Map<const Eigen::VectorXd> gradient(&found.gradients[i * width], static_cast<Eigen::Index>(width));
        Eigen::VectorXd slope(gradient.size());
        bool is_smooth = true;
        for (std::size_t k = 0; k < width; ++k) {
            const auto at = [&](std::size_t n) { return moved.pairs[4 * k + n].upper; };
            const double slim = (at(2) - at(1)) / (2 * step), wide = (at(3) - at(0)) / (4 * step);
            slope[static_cast<Eigen::Index>(k)] = (4 * slim - wide) / 3;
            is_smooth = is_smooth && std::abs(slim - wide) < 1e-6;
        }
        if (!is_smooth || slope.norm() < 1e-3) continue;
        ++errors.compared;
        errors.most = std::max(errors.most, (slope - gradient).cwiseAbs().maxCoeff() / slope.norm());
    }
    return errors;
}

int bench_robot_distances(const RobotDistanceBenchOptions& options)
{
    const RobotDescription description = open_robot(options.robot);
    RobotPlace place(description, Settings{});
    FclRobot fcl(description);
    const std::vector<LinkGeometry> bodies = bodies_around(options);
    place.set_obstacles(bodies), fcl.set_environment(bodies);
    const std::vector<double> numbers = random_configurations(options, place.robot);
    const auto count = static_cast<std::size_t>(options.configurations);

    struct Entrant {
        std::string name;
        std::function<void()> run;
        std::vector<double> distances{};
        double seconds = 0;
        std::size_t pairs = 0;
    };
    RobotDistances found;
    std::vector<Entrant> all;
    const auto add_ours = [&](std::string name, const RobotDistanceOptions& what) {
        all.push_back({std::move(name), [&, what] { place.robot.distances(place.world, numbers, found, what); }});
    };
    add_ours("oncollide", {.gradients = false, .depths = false});
    add_ours("oncollide, with gradients", {.depths = false});
    add_ours("oncollide, with gradients and depths", {});
    add_ours(fmt::format("oncollide, all pairs within {:g} mm", 1e3 * options.cutoff),
             {.cutoff = options.cutoff, .every_pair = true});
    std::vector<Eigen::Isometry3d> poses(description.links.size());
    std::vector<double> of_fcl(count);
    all.push_back({"FCL, OBBRSS meshes", [&] {
                       for (std::size_t i = 0; i < count; ++i) {
                           place.robot.link_poses(
                               std::span(numbers).subspan(i * place.robot.width(), place.robot.width()), poses);
                           of_fcl[i] = fcl.distance(poses);
                       }
                   }});
    say("{}robot      {}, {} bodies, {} random configurations\n\n", describe_program("robot-distances"),
        description.name, options.bodies, count);
    for (std::size_t k = 0; k < all.size(); ++k) {
        all[k].run(); // trees grow
        if (k == 0)
            for (const RobotDistance& d : found.pairs) all[k].distances.push_back(d.upper);
        all[k].pairs = k + 1 < all.size() ? found.pairs.size() : count;
    }
    for (int turn = 0; turn < options.repeats; ++turn)
        take_turns(all.size(), static_cast<std::size_t>(turn), [&](std::size_t k) {
            const double seconds = 1e-3 * least_ms(1, all[k].run);
            all[k].seconds = turn == 0 ? seconds : std::min(all[k].seconds, seconds);
        });
    std::vector<RobotFinding> truth(count);
    place.robot.check(place.world, numbers, truth);
    double most = 0;
    std::size_t meeting = 0, differ = 0, of_fcl_differ = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const bool meets = truth[i].verdict == Verdict::colliding;
        const double ours = all[0].distances[i];
        meeting += meets, differ += meets != (ours <= 0), of_fcl_differ += meets != (of_fcl[i] <= 0);
        if (ours > 0 && of_fcl[i] > 0) most = std::max(most, std::abs(ours - of_fcl[i]));
    }
    const GradientErrors errors =
        gradient_errors(place, numbers, std::min(count, static_cast<std::size_t>(options.differences)));
    ResultTable table(options.csv, {36});
    for (const Entrant& each : all)
        table.row(figures("who", each.name, "us", 1e6 * each.seconds / double(count), "of_oncollide",
                          each.seconds / all[0].seconds, "pairs", each.pairs),
                  figures("configurations", count, "bodies", options.bodies, "meeting", meeting, "differ",
                          each.name.starts_with("FCL") ? of_fcl_differ : differ, "most_apart", most, "gradients",
                          errors.compared, "gradient_error", errors.most));
    table.commit();
    say("\n{} of {} configurations collide; the distance is above 0 for {} of them, or 0 for others, and FCL's for "
        "{}.\n"
        "Where both find a gap, the two differ by {:.1e} m at most.\n"
        "{} gradients differ from differences of distances by {:.1e} of their length at most.\n",
        meeting, count, differ, of_fcl_differ, most, errors.compared, errors.most);
    return code_of(differ > 0);
}

} // namespace

void add_robot_distances_bench(Arguments bench)
{
    Benchmark<RobotDistanceBenchOptions> b(bench, "robot-distances",
                                           "The least distance of a robot's configurations among bodies, and FCL's",
                                           bench_robot_distances);
    b->seed = 1;
    b.input("URDF URDF", b->robot.urdf, "robot").required();
    b.input("--srdf FILE", b->robot.srdf, "SRDF file");
    b.option("--package NAME=FOLDER", b->robot.packages, "folder of the meshes named package://NAME/...").repeatable();
    b.whole("--bodies N", b->bodies, "bodies around the robot (default 40)", {0, 100'000});
    b.whole("--configurations N", b->configurations, "random configurations (default 1000)", {1, 1'000'000});
    b.option("--cutoff", b->cutoff, "of the row with all pairs (default 5cm)").length();
    b.whole("--differences N", b->differences, "configurations whose gradients are compared (default 100)",
            {0, 1'000'000});
    b.seed("bodies and configurations"), b.repeats("runs, of which the fastest counts"), b.csv("way to measure");
    b.footer("us: microseconds a configuration, one thread; pairs: of all configurations.\n"
             "Exit code 70: a distance is not above 0 exactly where check() finds no collision.\n"
             "Example:\n"
             "  oncollide-lab bench robot-distances panda.urdf --srdf panda.srdf");
}

} // namespace oncollide::tools
