// oncollide-lab bench robot: checks of configurations in MotionBenchMaker's problems, by meshes, models of spheres, and
// FCL.
#include "bench/robot/robot_place.hpp"
#include "cli/progress.hpp"
#include "peers/fcl_robot.hpp"
#include "robot/robot_world.hpp"
#include "robot/sphere_files.hpp"

#include <algorithm>
#include <memory>

#include <oncollide/robots/spheres/sphere_maker.hpp>

namespace oncollide::tools {
namespace {

struct RobotBenchOptions : SharedOptions {
    ProblemOptions problem;
    std::string spheres;
    double own_error = 0.005;
    int each = 100;
};

/// One way to check.
struct RobotEntrant {
    std::string name;
    std::function<void(const RobotWork& work)> set_environment;
    /// Sets hits[i] to 1 for each configuration that is not free. `self`: only against the robot itself.
    std::function<void(const RobotWork& work, bool self, std::vector<std::uint8_t>& hits)> run;
    double seconds = 0, self_seconds = 0;
    std::size_t missed = 0, refused = 0, free = 0, self_missed = 0, self_refused = 0;
};

RobotEntrant our_entrant(std::string name, std::shared_ptr<RobotPlace> place)
{
    return {std::move(name), [=](const RobotWork& work) { place->set_obstacles(work.obstacles); },
            [=, found = std::vector<RobotFinding>()](const RobotWork& work, bool self, auto& hits) mutable {
                found.resize(hits.size());
                place->robot.check(place->world, work.numbers, found, {.environment = !self});
                for (std::size_t i = 0; i < hits.size(); ++i) hits[i] = found[i].verdict != Verdict::separate;
            }};
}

/// The same, with a copy of the obstacles for each configuration.
RobotEntrant copies_entrant(const RobotDescription& robot)
{
    const auto place = std::make_shared<RobotPlace>(robot, Settings{});
    const auto poses = std::make_shared<std::vector<Eigen::Isometry3d>>();
    return {
        "oncollide, exact, own obstacles",
        [=](const RobotWork& work) {
            place->set_obstacles(work.obstacles);
            poses->clear();
            for (std::size_t i = 0; i < work.numbers.size() / place->robot.width(); ++i)
                for (const LinkGeometry& obstacle : work.obstacles) poses->push_back(obstacle.pose);
        },
        [=, found = std::vector<RobotFinding>()](const RobotWork& work, bool self, auto& hits) mutable {
            found.resize(hits.size());
            place->robot.check(place->world, {place->obstacles(), *poses}, work.numbers, found, {.environment = !self});
            for (std::size_t i = 0; i < hits.size(); ++i) hits[i] = found[i].verdict != Verdict::separate;
        }};
}

RobotEntrant fcl_entrant(const RobotDescription& description, const Robot& robot)
{
    const auto fcl = std::make_shared<FclRobot>(description);
    return {"FCL, OBBRSS meshes", [=](const RobotWork& work) { fcl->set_environment(work.obstacles); },
            [=, &robot, poses = std::vector<Eigen::Isometry3d>(description.links.size())](
                const RobotWork& work, bool self, auto& hits) mutable {
                for (std::size_t i = 0; i < hits.size(); ++i) {
                    robot.link_poses(std::span(work.numbers).subspan(i * robot.width(), robot.width()), poses);
                    hits[i] = self ? fcl->self_collides(poses) : fcl->collides(poses);
                }
            }};
}

SphereModel own_spheres(const RobotDescription& robot, double error)
{
    SphereModel model;
    for (const RobotLink& link : robot.links) {
        const LinkSurface surface(link);
        model.push_back(surface.triangles().empty() ? std::vector<CoverSphere>{} : SphereMaker(surface).within(error));
    }
    return model;
}

/// The first is the truth: exact tests.
std::vector<RobotEntrant> entrants_of(const RobotBenchOptions& options, const RobotDescription& robot,
                                      const std::shared_ptr<RobotPlace>& exact)
{
    std::vector<RobotEntrant> all{our_entrant("oncollide, exact", exact)};
    const auto add = [&](std::string name, const RobotDescription& description, const Settings& settings) {
        all.push_back(our_entrant(std::move(name), std::make_shared<RobotPlace>(description, settings)));
    };
    add("oncollide, within 1 mm", robot, {.max_error = 0.001});
    add("oncollide, within 1 cm", robot, {.max_error = 0.01});
    const auto padded = std::make_shared<RobotPlace>(robot, Settings{});
    padded->robot.set_padding({.environment = 0.02});
    all.push_back(our_entrant("oncollide, exact, 20 mm away", padded));
    all.push_back(copies_entrant(robot));
    const SphereModel own = own_spheres(robot, options.own_error);
    add(fmt::format("own {} spheres, {:g} mm", count_of(own), 1e3 * options.own_error), with_spheres(robot, own), {});
    if (!options.spheres.empty()) {
        std::vector<std::string> warnings;
        const SphereModel published = load_sphere_model(options.spheres, robot, warnings);
        add(fmt::format("published {} spheres", count_of(published)), with_spheres(robot, published), {});
    }
    all.push_back(fcl_entrant(robot, exact->robot));
    return all;
}

void race_robots(const RobotBenchOptions& options, const std::vector<PlanningProblem>& problems, const Robot& robot,
                 std::vector<RobotEntrant>& all)
{
    Progress progress("problems", problems.size());
    std::vector<std::vector<std::uint8_t>> hits(all.size()), self(all.size());
    for (std::size_t p = 0; p < problems.size(); ++p, progress.step()) {
        const RobotWork work = workload_of(problems[p], robot, options.each);
        for (std::size_t k = 0; k < all.size(); ++k) {
            hits[k].assign(static_cast<std::size_t>(options.each), 0), self[k] = hits[k];
            all[k].set_environment(work);
            all[k].run(work, false, hits[k]); // trees grow
        }
        take_turns(all.size(), p, [&](std::size_t k) {
            all[k].seconds += 1e-3 * least_ms(options.repeats, [&] { all[k].run(work, false, hits[k]); });
            all[k].self_seconds += 1e-3 * least_ms(options.repeats, [&] { all[k].run(work, true, self[k]); });
        });
        for (std::size_t k = 0; k < all.size(); ++k)
            for (std::size_t i = 0; i < hits[k].size(); ++i) {
                all[k].missed += hits[0][i] > hits[k][i], all[k].refused += hits[0][i] < hits[k][i];
                all[k].free += !hits[0][i];
                all[k].self_missed += self[0][i] > self[k][i], all[k].self_refused += self[0][i] < self[k][i];
            }
    }
}

int bench_robot(const RobotBenchOptions& options)
{
    const RobotDescription robot = open_robot(options.problem.robot);
    const std::vector<PlanningProblem> problems = open_problems(options.problem);
    const auto exact = std::make_shared<RobotPlace>(robot, Settings{});
    std::vector<RobotEntrant> all = entrants_of(options, robot, exact);
    say("{}robot      {}\nproblems   {}, each {} configurations\n\n", describe_program("robot"), robot.name,
        problems.size(), options.each);
    race_robots(options, problems, exact->robot, all);
    const std::size_t configurations = problems.size() * static_cast<std::size_t>(options.each);
    ResultTable table(options.csv, {32});
    for (const RobotEntrant& each : all)
        table.row(figures("who", each.name, "per_second", double(configurations) / each.seconds, "of_exact",
                          all.front().seconds / each.seconds, "self_per_second",
                          double(configurations) / each.self_seconds, "missed", each.missed, "refused", each.refused,
                          "self_missed", each.self_missed, "self_refused", each.self_refused),
                  figures("configurations", configurations, "free", each.free));
    table.commit();
    // Bounded checks and spheres that cover must not miss anything; FCL and published spheres may.
    return code_of(std::ranges::any_of(all, [](const RobotEntrant& each) {
        return each.missed > 0 && (each.name.starts_with("oncollide") || each.name.starts_with("own"));
    }));
}

} // namespace

void add_robot_bench(Arguments bench)
{
    Benchmark<RobotBenchOptions> b(
        bench, "robot", "Configurations of a robot in MotionBenchMaker's problems: meshes, models of spheres, and FCL",
        bench_robot);
    add_problem_options(b, b->problem);
    b.input("--spheres MODEL", b->spheres, "published model of spheres: cuRobo's .yml, or a .urdf of spheres");
    b.option("--own-error", b->own_error, "over-reach of our own spheres (default 5mm)").length();
    b.whole("--each N", b->each, "configurations of each problem, from start to goal", {1, 100'000});
    b.repeats("runs of each problem, of which the fastest counts"), b.csv("way to check");
    b.footer(
        "missed: configurations that collide, and are said to be free; refused: the reverse. The exact checks are\n"
        "the truth. One thread. 'of exact' is the speed relative to exact checks. 20 mm away: configurations with a\n"
        "body that is closer to a link are refused. Own obstacles: each configuration has a copy of its own, as in\n"
        "Robot::check() of WorldCopies.\n"
        "Exit code 70: a bounded check, or our own spheres, missed a collision.\n"
        "Example:\n"
        "  oncollide-lab bench robot panda.urdf --srdf panda.srdf --problems problems --spheres "
        "panda_spherized.urdf");
}

} // namespace oncollide::tools
