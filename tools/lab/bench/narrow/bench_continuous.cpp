// oncollide-lab bench continuous: when two moving meshes first meet, compared with FCL's modes; and an articulated
// body.
#include "bench/bench.hpp"
#include "bench/narrow/articulated.hpp"
#include "cli/options.hpp"
#include "common/race.hpp"
#include "common/statistics.hpp"
#include "common/text.hpp"
#include "fcl/fcl_pair.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::tools {
namespace {

struct ContinuousOptions {
    std::vector<std::string> meshes; ///< two files; empty: two generated knots
    int motions = 1000, steps = 400;
    double reach = 1;        ///< of the positions, in diagonals of the meshes
    double tolerance = 1e-4; ///< of the time, and of the distance in diagonals
    int samples = 200;       ///< poses before each contact that are tested
    std::uint64_t seed = 12345;
    std::string csv;
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

/// Returns how many results are wrong.
std::size_t bench_articulated(const ContinuousOptions& options, CsvFile& csv)
{
    constexpr int samples = 10;
    if (options.steps == 0) return 0;
    const ArticulatedResult r = walk_articulated_body(options.steps, options.tolerance, samples);
    say("\narticulated body: {} links, {} triangles, past {} posts of {} triangles; {} steps: {:.3g} ms, mean, {:.3g} "
        "ms, "
        "median; {} contacts; {} contradicted by exact tests of all pairs at {} poses in each step\n",
        r.links, grouped(r.triangles), r.posts, grouped(r.triangles_of_posts), options.steps, 1e-3 * mean(r.us),
        1e-3 * median(r.us), r.contacts, r.contradicted, samples);
    csv.row(Quoted{"articulated"}, r.triangles, Quoted{"posts"}, r.triangles_of_posts, 0, options.tolerance,
            options.steps, "oncollide", Digits{median(r.us), 4}, Digits{mean(r.us), 4}, r.contacts, r.contradicted, 0,
            0, 0);
    return r.contradicted;
}

/// Returns the exit code: 70 if a result of oncollide is wrong.
int bench_continuous(const ContinuousOptions& options)
{
    check_range("--motions", options.motions, 1, 10'000'000), check_range("--samples", options.samples, 0);
    check_range("--steps", options.steps, 0, 1'000'000);
    if (!(options.tolerance >= 1e-12 && options.tolerance <= 1))
        usage(fmt::format("--tolerance {}: must be from 1e-12 to 1", options.tolerance));
    if (!(options.reach > 0 && options.reach <= 1e6))
        usage(fmt::format("--reach {}: must be above 0, and at most 1e6", options.reach));
    if (options.meshes.size() != 0 && options.meshes.size() != 2) usage("bench continuous: give no meshes, or two");
    check_files({{"--csv", options.csv}}, options.meshes);
    CsvFile csv(options.csv, "a,a_triangles,b,b_triangles,reach,tolerance,motions,contender,median_us,mean_us,"
                             "contacts,missed,invented,early,late");
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
    say("{:<18}{:>12}{:>12}{:>8}{:>10}{:>8}{:>10}{:>8}{:>8}\n", "", "median, us", "mean, us", "ratio", "contacts",
        "missed", "invented", "early", "late");
    for (const SweepTally* t : {&ours, &advance, &sampled}) {
        say("{:<18}{:>12.1f}{:>12.1f}{:>8.1f}{:>10}{:>8}{:>10}{:>8}{:>8}\n", t->name, median(t->us), mean(t->us),
            median(t->us) / median(ours.us), t->contacts, t->missed, t->invented, t->early, t->late);
        csv.row(Quoted{name(0)}, a.triangles.size(), Quoted{name(1)}, b.triangles.size(), options.reach,
                options.tolerance, options.motions, t->name, Digits{median(t->us), 4}, Digits{mean(t->us), 4},
                t->contacts, t->missed, t->invented, t->early, t->late);
    }
    say("\noncollide: {} of {} results contradicted by {} exact tests each; {} left open\n", wrong, options.motions,
        options.samples + 1, open);
    wrong += bench_articulated(options, csv);
    csv.commit();
    return wrong ? int(ErrorKind::internal) : 0;
}

} // namespace

void add_continuous(Arguments bench)
{
    Arguments sub = bench.add_command("continuous", "When two moving meshes first meet");
    auto options = std::make_shared<ContinuousOptions>();
    sub.add_option("meshes A B", options->meshes, "two mesh files, scaled to a diagonal of 1 (default: two knots)")
        .expected(0, 2);
    sub.add_option("--motions N", options->motions, "random motions of both (default 1000)");
    sub.add_option("--reach R", options->reach, "largest coordinate of B's random positions (default 1)");
    sub.add_option("--tolerance T", options->tolerance, "of the time of contact and of the distance (default 1e-4)");
    sub.add_option("--samples N", options->samples, "poses before each contact that exact tests check (default 200)");
    sub.add_option("--steps N", options->steps,
                   "steps of an articulated body of 15 links and 20,000 triangles (default 400; 0: none)");
    sub.add_option("--seed S", options->seed, "seed of the motions (default 12345)");
    sub.add_option("--csv FILE", options->csv, "write one row per contender");
    sub.footer("Contenders take turns, motion by motion. missed: a contact that exact tests confirm is not found;\n"
               "early, late: the time is off by more than ten tolerances; invented: a contact is reported where the\n"
               "whole motion is certified free. Exit code 70: exact tests contradict a result of oncollide.");
    sub.action([options] { return bench_continuous(*options); });
}

} // namespace oncollide::tools
