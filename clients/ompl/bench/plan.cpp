// oncollide-ompl-bench plan: RRT-Connect in MotionBenchMaker's problems, with several checkers, and its plans judged.
#include "contenders.hpp"

#include <ompl/base/ScopedState.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/RandomNumbers.h>

#include "bench/common/benchmark.hpp"
#include "cli/command.hpp"
#include "cli/log.hpp"
#include "cli/progress.hpp"

namespace oncollide::tools {

namespace ob = ompl::base;

namespace {

struct PlanBenchOptions : SharedOptions {
    ProblemOptions problem;
    std::vector<std::string> spheres;
    double limit = 5;
    int samples = 10'000, seeds = 1;
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
    const double begin = processor_ms();
    const ob::PlannerStatus status =
        planner.solve(ob::PlannerTerminationCondition([&] { return processor_ms() > begin + 1e3 * options.limit; }));
    const double ms = processor_ms() - begin;
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
    ResultTable table(options.csv, {32});
    table.about(figures("robot", robot, "problems", plans, "samples", options.samples, "limit_s", options.limit,
                        "seeds", options.seeds));
    for (std::size_t k = 0; k < all.size(); ++k) {
        const PlanCounts& c = counts[k];
        const double solved = std::max(1.0, double(c.ms.size()));
        table.row(figures("who", all[k]->name(), "solved", c.ms.size(), "refused", c.refused, "mean_ms", mean(c.ms),
                          "median_ms", median(c.ms), "state_checks", double(c.state_checks) / solved, "edge_checks",
                          double(c.edge_checks) / solved, "edges", double(c.edges) / solved, "collide", c.collide,
                          "undecided", c.undecided, "refuted", c.refuted));
    }
    table.commit();
}

int bench_plan(const PlanBenchOptions& options)
{
    if (!(options.limit > 0)) usage("--limit: must be above 0");
    ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
    const RobotDescription robot = open_robot(options.problem.robot);
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
    for (std::size_t k = 0; k < all.size(); ++k)
        if (counts[k].refuted || (all[k]->certified() && counts[k].collide)) return code_of(true);
    return 0;
}

void add_plan(Arguments app)
{
    Benchmark<PlanBenchOptions> b(app, "plan",
                                  "RRT-Connect of OMPL in MotionBenchMaker's problems, with certified and sampled "
                                  "motions, spheres and FCL",
                                  bench_plan);
    b->seed = 1;
    add_problem_options(b, b->problem);
    b.option("--spheres MODEL", b->spheres, "published model of spheres: cuRobo's .yml, or a .urdf of spheres")
        .repeatable();
    b.option("--limit S", b->limit, "processor time of a plan at most, seconds (default 5)");
    b.whole("--samples N", b->samples, "exact checks of each motion of a plan", {1, 10'000'000});
    b.seed("the planner's random numbers");
    b.whole("--seeds N", b->seeds, "plans of each problem, with one seed after another", {1, 1000});
    b.flag("--no-fcl", b->no_fcl, "leave out FCL");
    b.csv("contender");
    b.footer("refused: the start or the goal is not valid. Means are of a solved problem, in processor time of one\n"
             "thread. state checks, edge checks: of states and of motions. edges: motions of a plan. collide: exact\n"
             "tests find a contact in the plan. undecided: exact tests do not decide the plan. refuted: motions that\n"
             "are certified although one of the exact samples collides. Exit code 70: a certified plan is in contact.\n"
             "Example:\n"
             "  ./dev bench plan panda.urdf --srdf panda.srdf --problems problems --spheres panda_spherized.urdf");
}

} // namespace

const Program program{.name = "oncollide-ompl-bench",
                      .summary = "Benchmarks of oncollide's validity checker and motion validator for OMPL.",
                      .footer = "See docs/ompl.md.",
                      .add_commands = add_plan};

} // namespace oncollide::tools
