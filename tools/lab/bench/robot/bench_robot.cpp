// oncollide-lab bench robot: checks of configurations in MotionBenchMaker's problems, by meshes, models of spheres, and
// FCL.
#include "bench/bench.hpp"
#include "bench/robot/robot_place.hpp"
#include "cli/options.hpp"
#include "cli/outputs.hpp"
#include "cli/progress.hpp"
#include "common/race.hpp"
#include "common/text.hpp"
#include "peers/fcl_robot.hpp"
#include "robot/robot_world.hpp"
#include "robot/sphere_files.hpp"

#include <algorithm>
#include <memory>

#include <oncollide/robots/spheres/sphere_maker.hpp>

namespace oncollide::tools {
namespace {

struct RobotBenchOptions {
    ProblemOptions problem;
    std::string spheres, csv;
    double own_error = 0.005;
    int each = 100, repeats = 3;
};

/// One way to check.
class RobotEntrant {
public:
    RobotEntrant(std::string name) : name_(std::move(name)) {}
    virtual ~RobotEntrant() = default;
    virtual void set_environment(const RobotWork& work) = 0;
    /// Sets hits[i] to 1 for each configuration that is not free. `self`: only against the robot itself.
    virtual void run(const RobotWork& work, bool self, std::vector<std::uint8_t>& hits) = 0;

    const std::string& name() const { return name_; }
    double seconds = 0, self_seconds = 0;
    std::size_t missed = 0, refused = 0, free = 0, self_missed = 0, self_refused = 0;

private:
    std::string name_;
};

class OurEntrant final : public RobotEntrant {
public:
    OurEntrant(std::string name, const RobotDescription& robot, const Settings& settings)
        : RobotEntrant(std::move(name)), place_(robot, settings)
    {
    }
    void set_environment(const RobotWork& work) override { place_.set_obstacles(work.obstacles); }
    void run(const RobotWork& work, bool self, std::vector<std::uint8_t>& hits) override
    {
        findings_.resize(hits.size());
        place_.robot.check(place_.world, work.numbers, findings_, {.environment = !self});
        for (std::size_t i = 0; i < hits.size(); ++i) hits[i] = findings_[i].verdict != Verdict::separate;
    }
    const Robot& robot() const { return place_.robot; }

private:
    RobotPlace place_;
    std::vector<RobotFinding> findings_;
};

class FclEntrant final : public RobotEntrant {
public:
    FclEntrant(const RobotDescription& description, const Robot& robot)
        : RobotEntrant("FCL, OBBRSS meshes"), fcl_(description), robot_(robot), poses_(description.links.size())
    {
    }
    void set_environment(const RobotWork& work) override { fcl_.set_environment(work.obstacles); }
    void run(const RobotWork& work, bool self, std::vector<std::uint8_t>& hits) override
    {
        const std::size_t width = robot_.width();
        for (std::size_t i = 0; i < hits.size(); ++i) {
            robot_.link_poses(std::span(work.numbers).subspan(i * width, width), poses_);
            hits[i] = self ? fcl_.self_collides(poses_) : fcl_.collides(poses_);
        }
    }

private:
    FclRobot fcl_;
    const Robot& robot_;
    std::vector<Eigen::Isometry3d> poses_;
};

SphereModel own_spheres(const RobotDescription& robot, double error)
{
    SphereModel model;
    for (const RobotLink& link : robot.links) {
        const LinkSurface surface(link);
        model.push_back(surface.triangles().empty() ? std::vector<CoverSphere>{} : SphereMaker(surface).within(error));
    }
    return model;
}

using RobotEntrants = std::vector<std::unique_ptr<RobotEntrant>>;

/// The first is the truth: exact tests.
RobotEntrants entrants_of(const RobotBenchOptions& options, const RobotDescription& robot)
{
    RobotEntrants all;
    const auto add = [&](std::string name, const RobotDescription& description, const Settings& settings) {
        all.push_back(std::make_unique<OurEntrant>(std::move(name), description, settings));
    };
    add("oncollide, exact", robot, {});
    const Robot& exact = static_cast<const OurEntrant&>(*all.front()).robot();
    add("oncollide, within 1 mm", robot, {.max_error = 0.001});
    add("oncollide, within 1 cm", robot, {.max_error = 0.01});
    const SphereModel own = own_spheres(robot, options.own_error);
    add(fmt::format("own {} spheres, {:g} mm", count_of(own), 1e3 * options.own_error), with_spheres(robot, own), {});
    if (!options.spheres.empty()) {
        std::vector<std::string> warnings;
        const SphereModel published = load_sphere_model(options.spheres, robot, warnings);
        add(fmt::format("published {} spheres", count_of(published)), with_spheres(robot, published), {});
    }
    all.push_back(std::make_unique<FclEntrant>(robot, exact));
    return all;
}

void race_robots(const RobotBenchOptions& options, const std::vector<PlanningProblem>& problems, const Robot& robot,
                 const RobotEntrants& all)
{
    Progress progress("problems", problems.size());
    std::vector<std::vector<std::uint8_t>> hits(all.size()), self(all.size());
    for (std::size_t p = 0; p < problems.size(); ++p, progress.step()) {
        const RobotWork work = workload_of(problems[p], robot, options.each);
        for (std::size_t k = 0; k < all.size(); ++k) {
            hits[k].assign(static_cast<std::size_t>(options.each), 0), self[k] = hits[k];
            all[k]->set_environment(work);
            all[k]->run(work, false, hits[k]); // trees grow
        }
        take_turns(all.size(), p, [&](std::size_t k) {
            all[k]->seconds += 1e-3 * least_ms(options.repeats, [&] { all[k]->run(work, false, hits[k]); });
            all[k]->self_seconds += 1e-3 * least_ms(options.repeats, [&] { all[k]->run(work, true, self[k]); });
        });
        for (std::size_t k = 0; k < all.size(); ++k)
            for (std::size_t i = 0; i < hits[k].size(); ++i) {
                all[k]->missed += hits[0][i] > hits[k][i], all[k]->refused += hits[0][i] < hits[k][i];
                all[k]->free += !hits[0][i];
                all[k]->self_missed += self[0][i] > self[k][i], all[k]->self_refused += self[0][i] < self[k][i];
            }
    }
}

void report_robots(const RobotBenchOptions& options, std::size_t configurations, const RobotEntrants& all)
{
    CsvFile csv(options.csv, "who,configurations,free,per_second,self_per_second,of_exact,missed,refused,"
                             "self_missed,self_refused");
    say("{:<30}{:>14}{:>10}{:>14}{:>9}{:>9}{:>13}{:>14}\n", "", "checks/s", "ratio", "self only/s", "missed", "refused",
        "self missed", "self refused");
    const double count = double(configurations);
    for (const auto& each : all) {
        const double ratio = all.front()->seconds / each->seconds;
        say("{:<30}{:>14.0f}{:>10.3f}{:>14.0f}{:>9}{:>9}{:>13}{:>14}\n", each->name(), count / each->seconds, ratio,
            count / each->self_seconds, each->missed, each->refused, each->self_missed, each->self_refused);
        csv.row(Quoted{each->name()}, configurations, each->free, Digits{count / each->seconds, 4},
                Digits{count / each->self_seconds, 4}, Digits{ratio, 4}, each->missed, each->refused, each->self_missed,
                each->self_refused);
    }
    csv.commit();
}

int bench_robot(const RobotBenchOptions& options)
{
    check_range("--each", options.each, 1, 100'000);
    check_range("--repeats", options.repeats, 1, 1000);
    check_files({{"--csv", options.csv}}, {options.problem.robot.urdf, options.problem.robot.srdf, options.spheres});
    const RobotDescription robot = open_robot(options.problem.robot);
    const std::vector<PlanningProblem> problems = open_problems(options.problem);
    const RobotEntrants all = entrants_of(options, robot);
    say("{}robot      {}\nproblems   {}, each {} configurations\n\n", describe_program("robot"), robot.name,
        problems.size(), options.each);
    race_robots(options, problems, static_cast<const OurEntrant&>(*all.front()).robot(), all);
    report_robots(options, problems.size() * static_cast<std::size_t>(options.each), all);
    say("\nmissed: configurations that collide, and are said to be free; refused: the reverse. The exact checks are "
        "the "
        "truth.\nOne thread. The ratio is the speed relative to exact checks.\n");
    // Bounded checks and spheres that cover must not miss anything; FCL and published spheres may.
    const bool fault = std::ranges::any_of(all, [](const auto& each) {
        return each->missed > 0 && (each->name().starts_with("oncollide") || each->name().starts_with("own"));
    });
    return fault ? 70 : 0;
}

} // namespace

void add_robot_bench(Arguments bench)
{
    Arguments sub = bench.add_command("robot", "Configurations of a robot in MotionBenchMaker's problems: meshes, "
                                               "models of spheres, and FCL");
    auto options = std::make_shared<RobotBenchOptions>();
    add_problem_options(sub, options->problem);
    sub.add_option("--spheres MODEL", options->spheres,
                   "published model of spheres: cuRobo's .yml, or a .urdf of spheres");
    sub.add_option("--own-error", options->own_error, "over-reach of our own spheres (default 5mm)").length();
    sub.add_option("--each N", options->each, "configurations of each problem, from start to goal (default 100)");
    sub.add_option("--repeats N", options->repeats, "runs of each problem, of which the fastest counts (default 3)");
    sub.add_option("--csv FILE", options->csv, "write the table as CSV");
    sub.footer(
        "Exit code 70: a bounded check, or our own spheres, missed a collision.\n"
        "Example:\n"
        "  oncollide-lab bench robot panda.urdf --srdf panda.srdf --problems problems --spheres panda_spherized.urdf");
    sub.action([options] { return bench_robot(*options); });
}

} // namespace oncollide::tools
