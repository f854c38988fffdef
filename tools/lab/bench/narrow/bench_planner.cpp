// oncollide-lab bench planner: which of many sampled poses of a body collide with a large static body?
#include "bench/common/benchmark.hpp"
#include "fcl/fcl_pair.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide::tools {
namespace {

struct PlannerOptions : SharedOptions {
    std::vector<std::string> meshes; ///< none, or the static and the moving mesh
    int poses = 100'000;
};

/// Poses of `moving`: random orientations, and positions in the AABB of `fixed` grown by half the size of `moving`.
std::vector<Eigen::Isometry3d> sample(const Mesh& fixed, const Mesh& moving, std::size_t count, std::uint64_t seed)
{
    const Eigen::Vector3d reach = fixed.bounds.half_extent().array() + 0.25 * moving.bounds.diagonal();
    std::vector<Eigen::Isometry3d> poses;
    for (std::uint64_t i = 0; i < count; ++i) {
        Eigen::Vector4d q;
        Eigen::Vector3d at;
        for (std::uint64_t k = 0; k < 4; ++k) q[int(k)] = u01(seed, i, k) - 0.5;
        for (std::uint64_t k = 0; k < 3; ++k) at[int(k)] = 2 * u01(seed, i, 10 + k) - 1;
        Eigen::Isometry3d pose(Eigen::Quaterniond(q.normalized()));
        pose.translation() = fixed.bounds.centre() + at.cwiseProduct(reach) - pose.linear() * moving.bounds.centre();
        poses.push_back(pose);
    }
    return poses;
}

std::string stem(const std::string& file)
{
    return std::filesystem::path(file).stem().string();
}

/// One library, or one of our exact levels, with its times and results.
struct PlannerEntrant {
    std::string who;
    ExactLevel exact = ExactLevel::off;
    std::function<void(std::vector<std::uint8_t>& hits)> run;
    double first = 0, second = 0; ///< seconds of the two calls; the first includes building the models and trees
    std::vector<std::uint8_t> hits;
};

PlannerEntrant fcl_in_a_loop(const Mesh& fixed, const Mesh& moving, std::span<const Eigen::Isometry3d> poses,
                             int threads)
{
    const auto run = [=, &fixed, &moving, fcl = std::shared_ptr<FclPair>()](std::vector<std::uint8_t>& hits) mutable {
        if (!fcl) fcl = std::make_shared<FclPair>(fixed, moving, FclNodes::obb);
        parallel_chunks(poses.size(), 64, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) hits[i] = fcl->contacts(poses[i]) > 0;
        });
    };
    return {"fcl", {}, run, 0, 0, {}};
}

PlannerEntrant in_one_call(const Mesh& fixed, const Mesh& moving, std::span<const Eigen::Isometry3d> poses, int threads,
                           ExactLevel exact)
{
    Settings settings;
    settings.threads = threads, settings.exact = exact;
    const auto run = [=, ours = std::shared_ptr<World>(), pairs = std::vector<PairOfModels>(),
                      findings = std::vector<Finding>(poses.size())](std::vector<std::uint8_t>& hits) mutable {
        if (!ours) {
            ours = std::make_shared<World>(settings);
            const ModelId a = ours->models().add(fixed), b = ours->models().add(moving);
            for (const Eigen::Isometry3d& pose : poses) pairs.push_back({{a}, {b, pose}});
        }
        ours->pairs().decide(pairs, findings);
        std::ranges::transform(findings, hits.begin(), [](const Finding& f) { return f.verdict != Verdict::separate; });
    };
    return {exact == ExactLevel::off ? "bound" : "exact", exact, run, 0, 0, {}};
}

/// Two calls of each entrant, in turns.
std::vector<PlannerEntrant> race(const Mesh& fixed, const Mesh& moving, std::span<const Eigen::Isometry3d> poses,
                                 int threads)
{
    std::vector<PlannerEntrant> all{fcl_in_a_loop(fixed, moving, poses, threads),
                                    in_one_call(fixed, moving, poses, threads, ExactLevel::off),
                                    in_one_call(fixed, moving, poses, threads, ExactLevel::predicates)};
    for (PlannerEntrant& entrant : all) entrant.hits.resize(poses.size());
    for (const std::size_t round : {0u, 1u})
        take_turns(all.size(), round, [&](std::size_t k) {
            PlannerEntrant& entrant = all[k];
            (round ? entrant.second : entrant.first) = 1e-3 * least_ms(1, [&] { entrant.run(entrant.hits); });
        });
    return all;
}

/// Many poses of one mesh against another in one call, compared with FCL in a loop. Returns the exit code: 70 if FCL
/// contradicts a result.
int bench_planner(const PlannerOptions& options)
{
    if (options.meshes.size() != 0 && options.meshes.size() != 2)
        usage("bench planner: give no meshes, or two: the static and the moving mesh");
    const bool given = !options.meshes.empty();
    const Mesh fixed = given ? load_mesh(options.meshes[0]) : make_terrain_mesh(4, 0.8, 186, 1);
    const Mesh moving = given ? load_mesh(options.meshes[1]) : make_torus_knot_mesh(2, 3, 0.3, 0.12, 0.05, 5000);
    const std::vector<Eigen::Isometry3d> poses = sample(fixed, moving, std::size_t(options.poses), options.seed);
    say("{}static     {} triangles\nmoving     {} triangles\nposes      {}, seed {}\n\n", describe_program("planner"),
        grouped(fixed.triangles.size()), grouped(moving.triangles.size()), grouped(poses.size()), options.seed);
    ResultTable table(options.csv);
    std::uint64_t wrong = 0, colliding = 0;
    for (int threads = 1; threads <= std::min(2, hardware_threads()); ++threads) {
        const std::vector<PlannerEntrant> all = race(fixed, moving, poses, threads);
        const std::vector<std::uint8_t>& expected = all.front().hits;
        colliding = std::uint64_t(std::ranges::count(expected, 1));
        table.about(figures("fixed", given ? stem(options.meshes[0]) : "terrain", "fixed_triangles",
                            fixed.triangles.size(), "moving", given ? stem(options.meshes[1]) : "knot",
                            "moving_triangles", moving.triangles.size(), "poses", poses.size(), "colliding",
                            colliding));
        for (const PlannerEntrant& entrant : all) {
            std::uint64_t false_positives = 0, missed = 0;
            for (std::size_t i = 0; i < poses.size(); ++i)
                false_positives += entrant.hits[i] > expected[i], missed += entrant.hits[i] < expected[i];
            wrong += missed + (entrant.exact == ExactLevel::off ? 0 : false_positives);
            table.row(figures("who", entrant.who, "threads", threads, "first_s", entrant.first, "second_s",
                              entrant.second, "ratio", all.front().second / entrant.second, "poses_per_s",
                              double(poses.size()) / entrant.second, "false", false_positives));
        }
    }
    say("\ncolliding  {} of {}; results that FCL contradicts: {}\n", grouped(colliding), grouped(poses.size()),
        grouped(wrong));
    table.commit();
    return code_of(wrong > 0);
}

} // namespace

void add_planner(Arguments bench)
{
    Benchmark<PlannerOptions> b(bench, "planner", "Many sampled poses of one mesh against another, in one call",
                                bench_planner);
    b.input("meshes STATIC MOVING", b->meshes, "two mesh files; the second is moved (default: terrain and knot)")
        .expected(0, 2);
    b.whole("--poses N", b->poses, "poses to sample", {1, 10'000'000});
    b.seed("the poses"), b.csv("kind of query and number of threads");
    b.footer(
        "fcl: FCL's OBB trees in a loop; bound: oncollide within its error; exact: oncollide, exact. The first call\n"
        "includes building FCL's models and oncollide's trees. Ratios compare second calls.\n"
        "'false': poses that oncollide leaves over and FCL finds separate.");
}

} // namespace oncollide::tools
