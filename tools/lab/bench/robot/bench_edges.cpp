// oncollide-lab bench edges: motions of a robot between configurations, certified and sampled as planners sample them.
#include "bench/robot/robot_place.hpp"
#include "cli/progress.hpp"

#include <cmath>

#include <oncollide/base/numbers/random.hpp>

namespace oncollide::tools {
namespace {

struct EdgeBenchOptions : SharedOptions {
    ProblemOptions problem;
    double length = 0.2, tolerance = 1e-4;
    int edges = 20, truth = 1000;
};

/// The joints that a problem moves, and the largest distance of two configurations within their limits.
struct Joints {
    std::vector<std::size_t> numbers;
    std::vector<double> lower, upper;
    double extent = 0;

    Joints(const Robot& robot, const PlanningProblem& problem)
    {
        for (const RobotJoint& joint : robot.description().joints) {
            const auto at = std::ranges::find(robot.names(), joint.name);
            if (at == robot.names().end() || !problem.goal.contains(joint.name)) continue;
            numbers.push_back(static_cast<std::size_t>(at - robot.names().begin()));
            lower.push_back(std::max(joint.lower, -M_PI)), upper.push_back(std::min(joint.upper, M_PI));
            extent = std::hypot(extent, upper.back() - lower.back());
        }
    }
};

/// Edges as a planner tries them: from a free configuration towards a random one, at most options.length of the extent
/// far.
struct Edges {
    std::vector<double> from, to;
    std::size_t count = 0;
};

Edges edges_of(const EdgeBenchOptions& options, const RobotPlace& place, const RobotWork& work, const Joints& joints,
               std::uint64_t problem)
{
    Edges edges;
    const std::size_t width = place.robot.width();
    std::vector<double> a(work.numbers.begin(), work.numbers.begin() + static_cast<std::ptrdiff_t>(width)), b = a;
    const std::uint64_t most_tries = 100 * static_cast<std::uint64_t>(options.edges);
    for (std::uint64_t attempt = 0; attempt < most_tries && edges.count < static_cast<std::size_t>(options.edges);
         ++attempt) {
        double square = 0;
        for (std::size_t j = 0; j < joints.numbers.size(); ++j) {
            const auto random = [&](std::uint64_t which) {
                const double u = u01(options.seed + problem, attempt, 2 * j + which);
                return joints.lower[j] + u * (joints.upper[j] - joints.lower[j]);
            };
            a[joints.numbers[j]] = random(0), b[joints.numbers[j]] = random(1);
            square += std::pow(b[joints.numbers[j]] - a[joints.numbers[j]], 2);
        }
        const double share = std::min(1.0, options.length * joints.extent / std::sqrt(square));
        for (const std::size_t n : joints.numbers) b[n] = a[n] + share * (b[n] - a[n]);
        RobotFinding at;
        place.robot.check(place.world, a, {&at, 1});
        if (at.verdict != Verdict::separate) continue;
        edges.from.insert(edges.from.end(), a.begin(), a.end()), edges.to.insert(edges.to.end(), b.begin(), b.end());
        ++edges.count;
    }
    return edges;
}

/// Whether samples find a contact: the end, then the others.
class Sampled {
public:
    Sampled(const RobotPlace& place, const Joints& joints, double resolution)
        : samples_(place), step_(resolution * joints.extent)
    {
    }
    bool collides(std::span<const double> from, std::span<const double> to)
    {
        double square = 0;
        for (std::size_t i = 0; i < from.size(); ++i) square += std::pow(to[i] - from[i], 2);
        const auto parts = static_cast<std::size_t>(std::max(1.0, std::ceil(std::sqrt(square) / step_)));
        return samples_.collide(from, to, parts, parts, parts) || samples_.collide(from, to, 1, parts - 1, parts);
    }
    /// Whether one of evenly spaced configurations up to a share of the edge collides.
    bool collides_before(std::span<const double> from, std::span<const double> to, double share, std::size_t parts)
    {
        std::vector<double> end(from.size());
        for (std::size_t i = 0; i < from.size(); ++i) end[i] = std::lerp(from[i], to[i], share);
        return samples_.collide(from, end, 1, parts - 1, parts);
    }

private:
    MotionSamples samples_;
    double step_;
};

struct EdgeCounts {
    std::size_t edges = 0, free = 0, contacts = 0, undecided = 0;
    std::size_t missed = 0;  ///< contacts that sampling does not find
    std::size_t refuted = 0; ///< certified edges on which a sample collides
    double first_seconds = 0, any_seconds = 0, sampled_seconds = 0;
};

void measure(const EdgeBenchOptions& options, RobotPlace& place, const PlanningProblem& problem, std::uint64_t number,
             EdgeCounts& counts)
{
    const RobotWork work = workload_of(problem, place.robot, 1);
    place.set_obstacles(work.obstacles);
    const Joints joints(place.robot, problem);
    const Edges edges = edges_of(options, place, work, joints, number);
    std::vector<RobotEdgeFinding> found(edges.count), any(edges.count);
    Sampled sampled(place, joints, 0.01);
    std::vector<std::uint8_t> hits(edges.count);
    const std::size_t width = place.robot.width();
    const auto edge = [&](const std::vector<double>& numbers, std::size_t i) {
        return std::span(numbers).subspan(i * width, width);
    };
    const auto certify = [&](bool first, std::vector<RobotEdgeFinding>& to) {
        place.robot.check_edges(place.world, edges.from, edges.to, to,
                                {.tolerance = options.tolerance, .first = first});
    };
    take_turns(3, number, [&](std::size_t k) {
        const double ms = least_ms(options.repeats, [&] {
            if (k < 2) return certify(k == 0, k == 0 ? found : any);
            for (std::size_t i = 0; i < edges.count; ++i)
                hits[i] = sampled.collides(edge(edges.from, i), edge(edges.to, i));
        });
        (k == 0 ? counts.first_seconds : k == 1 ? counts.any_seconds : counts.sampled_seconds) += 1e-3 * ms;
    });
    for (std::size_t i = 0; i < edges.count; ++i) {
        const bool contact = found[i].contact_by <= 1;
        counts.free += found[i].verdict == Verdict::separate, counts.contacts += contact;
        counts.undecided += found[i].verdict == Verdict::undecided;
        counts.missed += contact && !hits[i];
        counts.refuted += sampled.collides_before(edge(edges.from, i), edge(edges.to, i), found[i].clear_until,
                                                  static_cast<std::size_t>(options.truth));
    }
    counts.edges += edges.count;
}

int bench_edges(const EdgeBenchOptions& options)
{
    const RobotDescription robot = open_robot(options.problem.robot);
    const std::vector<PlanningProblem> problems = open_problems(options.problem);
    RobotPlace place(robot, {});
    EdgeCounts counts;
    Progress progress("problems", problems.size());
    for (std::size_t i = 0; i < problems.size(); ++i, progress.step()) measure(options, place, problems[i], i, counts);
    say("{}robot      {}\nproblems   {}, {} edges of at most {:g} of the extent\n\n", describe_program("edges"),
        robot.name, problems.size(), counts.edges, options.length);
    const auto each_us = [&](double seconds) { return 1e6 * seconds / static_cast<double>(counts.edges); };
    ResultTable table(options.csv);
    table.about(figures("robot", robot.name, "length", options.length, "samples", options.truth));
    table.row(figures("edges", counts.edges, "first_us", each_us(counts.first_seconds), "any_us",
                      each_us(counts.any_seconds), "sampled_us", each_us(counts.sampled_seconds), "free", counts.free,
                      "contacts", counts.contacts, "undecided", counts.undecided, "missed", counts.missed, "refuted",
                      counts.refuted));
    table.commit();
    return code_of(counts.refuted > 0);
}

} // namespace

void add_edges_bench(Arguments bench)
{
    Benchmark<EdgeBenchOptions> b(
        bench, "edges", "Motions of a robot in MotionBenchMaker's problems: certified, and sampled as planners do",
        bench_edges);
    b->seed = 1;
    add_problem_options(b, b->problem);
    b.whole("--edges N", b->edges, "motions of each problem", {1, 1'000'000});
    b.option("--length X", b->length,
             "longest motion, as a share of the extent of the joints' limits (default 0.2, as RRT-Connect in OMPL)");
    b.option("--tolerance X", b->tolerance, "closeness of the first contact, as a share of the motion (default 1e-4)");
    b.whole("--samples N", b->truth, "exact checks of each certified motion", {1, 10'000'000});
    b.seed("the random motions"), b.repeats("runs of each problem, of which the fastest counts"), b.csv("run");
    b.footer(
        "first: certified, with the first contact; any: certified, free or not; sampled: at 1 % of the extent, each\n"
        "per edge. missed: contacts that sampling misses; refuted: certified edges with a sample in contact.\n"
        "Exit code 70: an exact check found a contact where a motion is certified.\n"
        "Example:\n"
        "  oncollide-lab bench edges panda.urdf --srdf panda.srdf --problems problems");
}

} // namespace oncollide::tools
