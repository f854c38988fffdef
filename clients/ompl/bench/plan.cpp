// oncollide-ompl-bench plan: RRT-Connect in MotionBenchMaker's problems, with several checkers, and its plans judged.
#include "contenders.hpp"

#include <ctime>

#include <ompl/base/ScopedState.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/RandomNumbers.h>

#include "bench/bench.hpp"
#include "cli/command.hpp"
#include "cli/log.hpp"
#include "cli/options.hpp"
#include "cli/outputs.hpp"
#include "cli/progress.hpp"
#include "common/race.hpp"
#include "common/text.hpp"

namespace oncollide::tools {

namespace ob = ompl::base;

namespace {

struct PlanBenchOptions {
    ProblemOptions problem;
    std::vector<std::string> spheres;
    std::string csv;
    double limit = 5;
    int samples = 10'000, seeds = 1;
    std::uint64_t seed = 1;
    bool no_fcl = false;
};

/// The plans of one contender.
struct PlanCounts {
    std::vector<double> ms;  ///< of the solved ones
    std::size_t refused = 0; ///< the start or the goal is not valid
    std::size_t state_checks = 0, edge_checks = 0, edges = 0, collide = 0, undecided = 0, refuted = 0;
};

/// A plan as configurations, one after another; empty: none was found.
using Plan = std::vector<double>;

double processor_seconds()
{
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

ob::ScopedState<> state_of(const ob::SpaceInformationPtr& information, const Moving& moving, const Robot& robot,
                           const std::vector<double>& configuration)
{
    std::vector<double> values;
    for (const std::string& name : moving.names)
        values.push_back(configuration[std::size_t(std::ranges::find(robot.names(), name) - robot.names().begin())]);
    ob::ScopedState<> state(information);
    state = values;
    return state;
}

Plan plan(PlanContender& contender, const RobotWork& work, const Moving& moving, const RobotPlace& truth,
          const PlanBenchOptions& options, std::uint32_t seed, PlanCounts& counts)
{
    ompl::RNG::setSeed(seed); // of all generators that are made from now on
    ob::SpaceInformationPtr information;
    const std::shared_ptr<CountedStates> states = contender.begin(work, moving, information);
    information->setup();
    const ob::ScopedState<> start = state_of(information, moving, truth.robot, moving.start),
                            goal = state_of(information, moving, truth.robot, moving.goal);
    if (!information->isValid(start.get()) || !information->isValid(goal.get())) { // the planner would wait for others
        ++counts.refused;
        return {};
    }
    const auto problem = std::make_shared<ob::ProblemDefinition>(information);
    problem->setStartAndGoalStates(start, goal);
    ompl::geometric::RRTConnect planner(information);
    planner.setProblemDefinition(problem);
    planner.setup();
    const double begin = processor_seconds();
    const ob::PlannerStatus status =
        planner.solve(ob::PlannerTerminationCondition([&] { return processor_seconds() > begin + options.limit; }));
    const double ms = 1e3 * (processor_seconds() - begin);
    if (status != ob::PlannerStatus::EXACT_SOLUTION) return {};
    counts.ms.push_back(ms);
    counts.state_checks += states->count();
    counts.edge_checks += information->getMotionValidator()->getCheckedMotionCount();
    const ob::OncollideStates translate(*information,
                                        ob::OncollideJoints(truth.world, truth.robot, moving.names, moving.start));
    Plan found;
    for (const ob::State* state : problem->getSolutionPath()->as<ompl::geometric::PathGeometric>()->getStates()) {
        const std::vector<double> numbers = translate.configuration(state);
        found.insert(found.end(), numbers.begin(), numbers.end());
    }
    return found;
}

/// Certifies each motion of a plan, or finds a contact in it. Motions without a contact are sampled, too.
void judge(const RobotPlace& truth, const Plan& plan, int samples, PlanCounts& counts)
{
    const std::size_t width = truth.robot.width(), edges = plan.size() / width - 1;
    const std::span<const double> from(plan.data(), edges * width), to(plan.data() + width, edges * width);
    std::vector<RobotEdgeFinding> found(edges);
    truth.robot.check_edges(truth.world, from, to, found, {.first = false});
    MotionSamples motion(truth);
    bool collides = false, undecided = false;
    for (std::size_t i = 0; i < edges; ++i) {
        if (found[i].contact_by <= 1) {
            collides = true;
            continue;
        }
        const auto parts = static_cast<std::size_t>(samples);
        const bool sample =
            motion.collide(from.subspan(i * width, width), to.subspan(i * width, width), 0, parts, parts);
        if (found[i].verdict == Verdict::separate)
            counts.refuted += sample;
        else
            (sample ? collides : undecided) = true;
    }
    counts.edges += edges, counts.collide += collides, counts.undecided += undecided && !collides;
}

using PlanContenders = std::vector<std::unique_ptr<PlanContender>>;

PlanContenders contenders_of(const PlanBenchOptions& options, const RobotDescription& robot)
{
    PlanContenders all;
    all.push_back(std::make_unique<OurContender>("oncollide, certified", robot, true));
    all.push_back(std::make_unique<OurContender>("oncollide, sampled", robot, false));
    for (const std::string& file : options.spheres) {
        std::vector<std::string> warnings;
        const SphereModel model = load_sphere_model(file, robot, warnings);
        log_warnings(warnings);
        const RobotDescription spheres = without_pairs_that_always_overlap(with_spheres(robot, model));
        all.push_back(std::make_unique<OurContender>(fmt::format("{} published spheres, sampled", count_of(model)),
                                                     spheres, false));
    }
    if (!options.no_fcl) all.push_back(fcl_contender(robot));
    return all;
}

void report(const PlanBenchOptions& options, const std::string& robot, std::size_t plans, const PlanContenders& all,
            const std::vector<PlanCounts>& counts)
{
    CsvFile csv(options.csv,
                "robot,who,problems,solved,refused,mean_ms,median_ms,state_checks,edge_checks,edges,collide,"
                "undecided,refuted,samples,limit_s,seeds");
    say("{:<32}{:>8}{:>9}{:>12}{:>12}{:>10}{:>8}{:>8}{:>9}{:>11}{:>9}\n", "", "solved", "refused", "mean, ms",
        "median, ms", "states", "edges", "of plan", "collide", "undecided", "refuted");
    for (std::size_t k = 0; k < all.size(); ++k) {
        const PlanCounts& c = counts[k];
        const double solved = std::max(1.0, double(c.ms.size()));
        say("{:<32}{:>8}{:>9}{:>12.4g}{:>12.4g}{:>10.0f}{:>8.1f}{:>8.1f}{:>9}{:>11}{:>9}\n", all[k]->name(),
            c.ms.size(), c.refused, mean(c.ms), median(c.ms), double(c.state_checks) / solved,
            double(c.edge_checks) / solved, double(c.edges) / solved, c.collide, c.undecided, c.refuted);
        csv.row(Quoted{robot}, Quoted{all[k]->name()}, plans, c.ms.size(), c.refused, Digits{mean(c.ms), 4},
                Digits{median(c.ms), 4}, Digits{double(c.state_checks) / solved, 4},
                Digits{double(c.edge_checks) / solved, 4}, Digits{double(c.edges) / solved, 4}, c.collide, c.undecided,
                c.refuted, options.samples, options.limit, options.seeds);
    }
    csv.commit();
}

int bench_plan(const PlanBenchOptions& options)
{
    check_range("--samples", options.samples, 1, 10'000'000);
    check_range("--seeds", options.seeds, 1, 1000);
    if (!(options.limit > 0)) usage("--limit: must be above 0");
    const RobotOptions& files = options.problem.robot;
    check_files({{"--csv", options.csv}}, {files.urdf, files.srdf});
    ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
    const RobotDescription robot = open_robot(files);
    const std::vector<PlanningProblem> problems = open_problems(options.problem);
    const PlanContenders all = contenders_of(options, robot);
    std::vector<PlanCounts> counts(all.size());
    RobotPlace truth(robot, {});
    Progress progress("problems", problems.size());
    for (std::size_t p = 0; p < problems.size(); ++p, progress.step()) {
        const RobotWork work = workload_of(problems[p], truth.robot, 2);
        const Moving moving = moving_of(problems[p], truth.robot);
        truth.set_obstacles(work.obstacles);
        for (int s = 0; s < options.seeds; ++s)
            take_turns(all.size(), p, [&](std::size_t k) {
                const auto seed = std::uint32_t(options.seed) + std::uint32_t(s);
                const Plan found = plan(*all[k], work, moving, truth, options, seed, counts[k]);
                if (!found.empty()) judge(truth, found, options.samples, counts[k]);
            });
    }
    const std::size_t plans = problems.size() * static_cast<std::size_t>(options.seeds);
    say("{}robot      {}\nproblems   {}, {} seeds: {} plans; at most {:g} s each\n\n", describe_program("plan"),
        robot.name, problems.size(), options.seeds, plans, options.limit);
    report(options, robot.name, plans, all, counts);
    say("\nrefused: the start or the goal is not valid. Means are of a solved problem, in processor time of one "
        "thread.\n"
        "states, edges: checks of states and of motions. of plan: motions of a plan. collide: exact tests find a "
        "contact in "
        "the\nplan. undecided: exact tests do not decide the plan. refuted: motions that are certified although one of "
        "{} "
        "exact\nsamples collides.\n",
        options.samples);
    for (std::size_t k = 0; k < all.size(); ++k)
        if (counts[k].refuted || (all[k]->certified() && counts[k].collide)) return int(ErrorKind::internal);
    return 0;
}

void add_plan(Arguments app)
{
    Arguments sub = app.add_command("plan", "RRT-Connect of OMPL in MotionBenchMaker's problems, with certified and "
                                            "sampled motions, spheres and FCL");
    auto options = std::make_shared<PlanBenchOptions>();
    add_problem_options(sub, options->problem);
    sub.add_option("--spheres MODEL", options->spheres,
                   "published model of spheres: cuRobo's .yml, or a .urdf of spheres")
        .repeatable();
    sub.add_option("--limit S", options->limit, "processor time of a plan at most, seconds (default 5)");
    sub.add_option("--samples N", options->samples, "exact checks of each motion of a plan (default 10000)");
    sub.add_option("--seed N", options->seed, "of the planner's random numbers (default 1)");
    sub.add_option("--seeds N", options->seeds, "plans of each problem, with one seed after another (default 1)");
    sub.add_flag("--no-fcl", options->no_fcl, "leave out FCL");
    sub.add_option("--csv FILE", options->csv, "write the table as CSV");
    sub.footer("Exit code 70: a certified plan is in contact.\n"
               "Example:\n"
               "  ./dev bench plan panda.urdf --srdf panda.srdf --problems problems --spheres panda_spherized.urdf");
    sub.action([options] { return bench_plan(*options); });
}

} // namespace

const Program program{.name = "oncollide-ompl-bench",
                      .summary = "Benchmarks of oncollide's validity checker and motion validator for OMPL.",
                      .footer = "See docs/ompl.md.",
                      .add_commands = add_plan};

} // namespace oncollide::tools
