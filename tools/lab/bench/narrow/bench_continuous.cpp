// oncollide-lab bench continuous: when two moving meshes first meet, compared with FCL's modes; and an articulated
// body.
#include "bench/common/benchmark.hpp"
#include "bench/narrow/articulated.hpp"
#include "fcl/fcl_pair.hpp"

#include <algorithm>
#include <filesystem>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::tools {
namespace {

struct ContinuousOptions : SharedOptions {
    std::vector<std::string> meshes; ///< two files; empty: two generated knots
    int motions = 1000, steps = 400;
    double reach = 1;        ///< of the positions, in diagonals of the meshes
    double tolerance = 1e-4; ///< of the time, and of the distance in diagonals
    int samples = 200;       ///< poses before each contact that are tested
};

constexpr double no_contact = std::numeric_limits<double>::infinity();

/// The mesh, centred, with a diagonal of 1.
Mesh mesh_of_unit_size(Mesh mesh)
{
    const Eigen::Vector3d centre = mesh.bounds.centre();
    const double size = mesh.bounds.diagonal();
    for (Eigen::Vector3d& v : mesh.vertices) v = (v - centre) / size;
    return make_mesh("unit", std::move(mesh.vertices), std::move(mesh.triangles));
}

Eigen::Isometry3d pose_of_motion(std::uint64_t seed, std::uint64_t item, double reach)
{
    Eigen::Vector4d q;
    for (std::uint64_t k = 0; k < 4; ++k) q[int(k)] = u01(seed, item, k) - 0.5;
    Eigen::Isometry3d pose(Eigen::Quaterniond(q.normalized()));
    for (std::uint64_t k = 0; k < 3; ++k) pose.translation()[int(k)] = reach * (2 * u01(seed, item, 10 + k) - 1);
    return pose;
}

struct Ways {
    Eigen::Isometry3d a, to_a, b, to_b;
};

/// A turns about a point near it; B moves past it.
Ways random_ways(const ContinuousOptions& options, std::uint64_t i)
{
    return {pose_of_motion(options.seed, 4 * i, 0), pose_of_motion(options.seed, 4 * i + 1, 0.2),
            pose_of_motion(options.seed, 4 * i + 2, options.reach),
            pose_of_motion(options.seed, 4 * i + 3, options.reach)};
}

struct SweepTally {
    std::string name;
    std::vector<double> us{};
    std::size_t contacts = 0, missed = 0, invented = 0, early = 0, late = 0;

    void add(double time_of_contact, const SweepResult& truth, double tolerance)
    {
        const bool found = time_of_contact < no_contact;
        contacts += found;
        if (truth.verdict == Verdict::separate) {
            invented += found;
        } else if (truth.verdict == Verdict::colliding) {
            missed += !found;
            early += time_of_contact < truth.clear_until - 10 * tolerance;
            late += found && time_of_contact > truth.contact_by + 10 * tolerance;
        }
    }
};

template <class Work>
auto timed_in(SweepTally& tally, Work work)
{
    const auto from = Clock::now();
    const auto result = work();
    tally.us.push_back(1000 * milliseconds_since(from));
    return result;
}

/// Two meshes in a World and in FCL.
class MovingMeshes {
public:
    MovingMeshes(const Mesh& a, const Mesh& b)
        : a_(world_.models().add(a)), b_(world_.models().add(b)), fcl_a_(make_fcl_geometry(a, FclNodes::obbrss)),
          fcl_b_(make_fcl_geometry(b, FclNodes::obbrss))
    {
    }
    SweepResult sweep(const Ways& w, double tolerance) const
    {
        return world_.pairs().sweep({a_, {w.a, w.to_a}}, {b_, {w.b, w.to_b}},
                                    {.time_tolerance = tolerance, .gap_tolerance = tolerance});
    }
    double fcl(const Ways& w, FclSweep how, double tolerance) const
    {
        return fcl_time_of_contact({fcl_a_, w.a}, w.to_a, {fcl_b_, w.b}, w.to_b, how, tolerance);
    }
    /// True if the exact tests of single poses contradict the result.
    bool contradicts(const Ways& w, const SweepResult& r, int samples) const
    {
        const RigidMotion of_a(w.a, w.to_a), of_b(w.b, w.to_b);
        const auto meets = [&](double time) {
            const PlacedModel a{a_, of_a.pose(time)}, b{b_, of_b.pose(time)};
            return world_.pairs().decide(a, b).verdict == Verdict::colliding;
        };
        for (int k = 0; k < samples; ++k)
            if (const double time = r.clear_until * k / samples; time < r.clear_until && meets(time)) return true;
        return r.verdict == Verdict::colliding && !meets(r.contact_by);
    }

private:
    World world_;
    ModelId a_, b_;
    FclGeometry fcl_a_, fcl_b_;
};

Figures figures_of(const SweepTally& t, const SweepTally& ours)
{
    return figures("contender", t.name, "median_us", median(t.us), "mean_us", mean(t.us), "ratio",
                   median(t.us) / median(ours.us), "contacts", t.contacts, "missed", t.missed, "invented", t.invented,
                   "early", t.early, "late", t.late);
}

/// Returns how many results are wrong.
std::size_t bench_articulated(const ContinuousOptions& options, ResultTable& table)
{
    constexpr int samples = 10;
    if (options.steps == 0) return 0;
    const ArticulatedResult r = walk_articulated_body(options.steps, options.tolerance, samples);
    say("\narticulated body: {} links, {} triangles, past {} posts of {} triangles; {} steps: {:.3g} ms, mean, {:.3g} "
        "ms, median; {} contacts; {} contradicted by exact tests of all pairs at {} poses in each step\n",
        r.links, grouped(r.triangles), r.posts, grouped(r.triangles_of_posts), options.steps, 1e-3 * mean(r.us),
        1e-3 * median(r.us), r.contacts, r.contradicted, samples);
    table.about(figures("a", "articulated", "a_triangles", r.triangles, "b", "posts", "b_triangles",
                        r.triangles_of_posts, "reach", 0, "tolerance", options.tolerance, "motions", options.steps));
    const SweepTally tally{.name = "oncollide", .us = r.us, .contacts = r.contacts, .missed = r.contradicted};
    table.row({}, figures_of(tally, tally));
    return r.contradicted;
}

/// Returns the exit code: 70 if a result of oncollide is wrong.
int bench_continuous(const ContinuousOptions& options)
{
    if (!(options.tolerance >= 1e-12 && options.tolerance <= 1))
        usage(fmt::format("--tolerance {}: must be from 1e-12 to 1", options.tolerance));
    if (!(options.reach > 0 && options.reach <= 1e6))
        usage(fmt::format("--reach {}: must be above 0, and at most 1e6", options.reach));
    if (options.meshes.size() != 0 && options.meshes.size() != 2) usage("bench continuous: give no meshes, or two");
    const bool given = !options.meshes.empty();
    const auto load = [&](std::size_t i) {
        return mesh_of_unit_size(given ? load_mesh(options.meshes[i])
                                       : make_torus_knot_mesh(2, i ? 5 : 3, 1, 0.4, 0.15, 5000));
    };
    const auto name = [&](std::size_t i) {
        return given ? std::filesystem::path(options.meshes[i]).stem().string() : std::string(i ? "knot-2-5" : "knot");
    };
    const Mesh a = load(0), b = load(1);
    const MovingMeshes pair(a, b);
    say("{}a          {}, {} triangles\nb          {}, {} triangles\nmotions    {}, seed {}, tolerance {:g}\n\n",
        describe_program("cpu"), name(0), grouped(a.triangles.size()), name(1), grouped(b.triangles.size()),
        grouped(std::size_t(options.motions)), options.seed, options.tolerance);
    SweepTally ours{"oncollide"}, advance{"fcl-advancement"}, sampled{"fcl-sampled"};
    std::size_t wrong = 0, open = 0;
    for (std::uint64_t i = 0; i < std::uint64_t(options.motions); ++i)
        pair.sweep(random_ways(options, i), options.tolerance);
    for (std::uint64_t i = 0; i < std::uint64_t(options.motions); ++i) {
        const Ways ways = random_ways(options, i);
        const SweepResult found = timed_in(ours, [&] { return pair.sweep(ways, options.tolerance); });
        ours.contacts += found.verdict == Verdict::colliding;
        open += found.verdict == Verdict::within || found.verdict == Verdict::undecided;
        wrong += pair.contradicts(ways, found, options.samples);
        for (const auto& [tally, how] :
             {std::pair(&advance, FclSweep::advancement), std::pair(&sampled, FclSweep::sampled)})
            tally->add(timed_in(*tally, [&] { return pair.fcl(ways, how, options.tolerance); }), found,
                       options.tolerance);
    }
    ResultTable table(options.csv, {18});
    table.about(figures("a", name(0), "a_triangles", a.triangles.size(), "b", name(1), "b_triangles",
                        b.triangles.size(), "reach", options.reach, "tolerance", options.tolerance, "motions",
                        options.motions));
    for (const SweepTally* t : {&ours, &advance, &sampled}) table.row(figures_of(*t, ours));
    say("\noncollide: {} of {} results contradicted by {} exact tests each; {} left open\n", wrong, options.motions,
        options.samples + 1, open);
    wrong += bench_articulated(options, table);
    table.commit();
    return code_of(wrong > 0);
}

} // namespace

void add_continuous(Arguments bench)
{
    Benchmark<ContinuousOptions> b(bench, "continuous", "When two moving meshes first meet", bench_continuous);
    b.input("meshes A B", b->meshes, "two mesh files, scaled to a diagonal of 1 (default: two knots)").expected(0, 2);
    b.whole("--motions N", b->motions, "random motions of both", {1, 10'000'000});
    b.option("--reach R", b->reach, "largest coordinate of B's random positions (default 1)");
    b.option("--tolerance T", b->tolerance, "of the time of contact and of the distance (default 1e-4)");
    b.whole("--samples N", b->samples, "poses before each contact that exact tests check", {0});
    b.whole("--steps N", b->steps, "steps of an articulated body of 15 links and 20,000 triangles; 0: none",
            {0, 1'000'000});
    b.seed("the motions"), b.csv("contender");
    b.footer("Contenders take turns, motion by motion. missed: a contact that exact tests confirm is not found;\n"
             "early, late: the time is off by more than ten tolerances; invented: a contact is reported where the\n"
             "whole motion is certified free. Exit code 70: exact tests contradict a result of oncollide.");
}

} // namespace oncollide::tools
