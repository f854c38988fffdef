// oncollide-lab bench narrow: time of a query of two meshes, compared with the narrow phases of other libraries.
#include "bench/common/benchmark.hpp"
#include "bench/narrow/narrow_report.hpp"

#include <algorithm>
#include <cmath>

#include <oncollide/base/text/near_word.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::tools {
namespace {

struct NarrowOptions : SharedOptions {
    std::vector<std::string> meshes; ///< none or two files
    bool use_poses = false;          ///< a pose file instead of generated poses
    std::string poses;               ///< that file; empty: the set in the data folder, with its own meshes
    std::string distances, ask;
    std::string depths;       ///< of the sphere-trees, each also followed by FCL; empty: the usual ones
    std::string poses_csv;    ///< one row per pose, with the times of boolean queries
    std::optional<int> count; ///< poses per distance, or poses of the file
};

namespace fs = std::filesystem;

std::vector<NarrowQuery> parse_queries(const std::string& list)
{
    std::array<bool, 3> wanted{};
    for (const std::string& part : split(list)) {
        const auto found = std::find(query_names.begin(), query_names.end(), part);
        if (found == query_names.end())
            usage(fmt::format("--query {}: unknown query{}", part,
                              valid_names(part, {query_names.begin(), query_names.end()}, "valid")));
        wanted[std::size_t(found - query_names.begin())] = true;
    }
    std::vector<NarrowQuery> queries;
    for (NarrowQuery query : {NarrowQuery::boolean, NarrowQuery::all, NarrowQuery::distance})
        if (wanted[std::size_t(query)]) queries.push_back(query);
    return queries;
}

struct BenchedMesh {
    std::string name;
    Mesh mesh;
};

/// The mesh without triangles of zero area: the peers disagree about their intersections.
BenchedMesh with_area(BenchedMesh named)
{
    const Mesh& mesh = named.mesh;
    if (mesh.zero_area == 0) return named;
    std::vector<Triangle> kept;
    for (const Triangle& t : mesh.triangles) {
        const std::vector<Eigen::Vector3d> corners{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
        if (make_mesh(named.name, corners, {{0, 1, 2}}).zero_area == 0) kept.push_back(t);
    }
    return {named.name, make_mesh(named.name + ", without zero-area triangles", mesh.vertices, std::move(kept))};
}

/// Opens two files, or the pair of the pose set, or generates two meshes.
std::array<BenchedMesh, 2> open_meshes(const NarrowOptions& options)
{
    const auto load = [](const fs::path& path) { return with_area({path.stem().string(), load_mesh(path)}); };
    if (options.meshes.size() == 2) return {load(options.meshes[0]), load(options.meshes[1])};
    if (options.use_poses) {
        const PoseSet set = pose_set(data_folder(options.data));
        return {load(set.mesh_a), load(set.mesh_b)};
    }
    return {BenchedMesh{"knot-3-4", make_torus_knot_mesh(3, 4, 1, 0.4, 0.18, 5082)},
            BenchedMesh{"knot-2-3", make_torus_knot_mesh(2, 3, 1, 0.4, 0.18, 5144)}};
}

/// Reads the poses of a file, with exact results if it has them.
NarrowWorkload read_workload(const NarrowOptions& options)
{
    std::vector<KnownPose> poses =
        read_known_poses(options.poses.empty() ? pose_set(data_folder(options.data)).poses : fs::path(options.poses));
    if (options.count && std::size_t(*options.count) < poses.size()) poses.resize(std::size_t(*options.count));
    return workload_of(std::move(poses));
}

void check(const NarrowOptions& options)
{
    if (options.meshes.size() == 1) usage(fmt::format("{}: a second mesh is required", options.meshes[0]));
    if (!options.poses.empty() && options.meshes.empty())
        usage(fmt::format("--poses {}: needs the two meshes that the poses are for: MESH_A MESH_B", options.poses));
    if (options.use_poses && options.poses.empty() && !options.meshes.empty())
        usage("--poses: the data folder's poses have their own meshes; name a pose file or no meshes");
    if (options.use_poses && !options.distances.empty()) usage("--distances: does not apply to the poses of a file");
}

void print_settings(const NarrowOptions& options, const NarrowResult& result, const NarrowContenders& contenders)
{
    say("{}", describe_program("narrow phase only"));
    print_missing(contenders.missing);
    const auto colliding = std::count(result.truth.colliding.begin(), result.truth.colliding.end(), true);
    say("meshes     {} ({} triangles), {} ({})\n"
        "poses      {}, {} colliding{}; least of {} runs of each query, after a warm-up pass\n",
        result.mesh_a, grouped(result.triangles_a), result.mesh_b, grouped(result.triangles_b),
        grouped(result.workload.poses.size()), grouped(std::uint64_t(colliding)),
        options.use_poses ? "" : fmt::format(", seed {}", options.seed), options.repeats);
    flush_stdout();
}

/// Removes contenders that crash on meshes with too few triangles, and prints their names.
void leave_out_fragile(std::vector<NarrowContender>& contenders, std::size_t triangles)
{
    std::erase_if(contenders, [&](const NarrowContender& contender) {
        if (triangles < contender.least)
            say("left out   {}: crashes on meshes of fewer than {} triangles\n", contender.name, contender.least);
        return triangles < contender.least;
    });
}

/// Keeps the shard's groups of poses; the poses themselves depend on all groups.
void keep_groups(const Shard& shard, NarrowWorkload& workload)
{
    const auto [first, end] = shard.range(workload.groups.size());
    keep_part(shard, workload.groups, "distances");
    std::erase_if(workload.poses, [&](const NarrowPose& pose) { return pose.group < first || pose.group >= end; });
    for (NarrowPose& pose : workload.poses) pose.group -= first;
}

/// Compares only the narrow phase, with one pair of meshes in many poses, with other libraries. Returns the exit code:
/// 70 if oncollide missed a collision or one of its exact results is wrong.
int bench_narrow(const NarrowOptions& options)
{
    check(options);
    const Shard shard = shard_from(options.shard);
    NarrowResult result;
    result.queries = parse_queries(options.ask.empty() ? "boolean,all,distance" : options.ask);
    const std::vector<double> percents =
        parse_distances(options.distances.empty() ? "0,0.1,1,5,10,20,40" : options.distances);
    NarrowContenders contenders = all_contenders().narrow;
    if (!options.depths.empty()) {
        std::erase_if(contenders.all, [](const NarrowContender& c) { return c.name.starts_with("walk-"); });
        for (int depth : parse_depths("--depths", options.depths))
            for (bool then_fcl : {false, true}) contenders.all.push_back(sphere_walk(depth, then_fcl));
    }
    contenders.keep(options.only);
    const auto supports_any = [&](const NarrowContender& contender) {
        return std::any_of(result.queries.begin(), result.queries.end(),
                           [&](NarrowQuery query) { return supports(contender, query); });
    };
    if (std::none_of(contenders.all.begin(), contenders.all.end(), supports_any))
        usage(fmt::format("--only {}: supports none of --query {}", options.only, options.ask));
    const std::array<BenchedMesh, 2> meshes = open_meshes(options);
    const Mesh &a = meshes[0].mesh, &b = meshes[1].mesh;
    result.mesh_a = meshes[0].name, result.triangles_a = a.triangles.size();
    result.mesh_b = meshes[1].name, result.triangles_b = b.triangles.size();
    result.diagonal = a.bounds.diagonal(), result.seed = options.seed;
    result.workload = options.use_poses
                          ? read_workload(options)
                          : make_workload(a, b, percents, std::size_t(options.count.value_or(100)), options.seed);
    keep_groups(shard, result.workload);
    result.truth = judge(a, b, result.workload, result.queries);
    print_settings(options, result, contenders);
    leave_out_fragile(contenders.all, std::min(result.triangles_a, result.triangles_b));
    result.rows = race(a, b, result.workload, result.truth, contenders.all, result.queries, options.repeats);
    print_narrow(result);
    if (!options.csv.empty())
        write_narrow_csv(
            options.csv,
            shard.line(fmt::format("bench narrow, {} and {}, query {}, distances {}, count {}, seed {}, only {}",
                                   printable(result.mesh_a), printable(result.mesh_b), options.ask,
                                   options.use_poses ? "of a file" : options.distances, options.count.value_or(0),
                                   options.seed, options.only)),
            result);
    if (!options.poses_csv.empty()) write_poses_csv(options.poses_csv, result);
    if (!options.plot.empty()) draw_narrow_plot(options.plot, result);
    return code_of(broken_promise(result));
}

} // namespace

void add_poses(Arguments bench)
{
    Benchmark<NarrowOptions> b(
        bench, "poses", "One pair of meshes in 1,000 poses with known results (needs the data folder)", bench_narrow);
    b->use_poses = true, b->ask = "boolean", b->depths = "4-8", b->repeats = 5;
    b.data("poses/");
    b.option("--depths LIST", b->depths, "depths of the sphere-trees (default 4-8)");
    b.repeats("number of runs; each query's least time counts");
    b.whole("--poses N", b->count, "use only the first N poses", {1, 100'000});
    b.output("--csv", "FILE", b->poses_csv, "write one row per pose");
    b.footer(
        "The same as 'oncollide-lab bench narrow --poses --query boolean' with FCL and these depths; each depth also\n"
        "with FCL for the pairs that are left over.");
    b.prepare([](NarrowOptions& o) {
        o.only = "fcl-obb,fcl-obbrss";
        for (int depth : parse_depths("--depths", o.depths)) o.only += fmt::format(",walk-{0},walk-{0}+fcl", depth);
    });
}

void add_narrow(Arguments bench)
{
    Benchmark<NarrowOptions> b(bench, "narrow", "Only the narrow phase, on two meshes, compared with other libraries",
                               bench_narrow);
    b.input("meshes MESH_A MESH_B", b->meshes, "two mesh files; the second is moved (default: two generated knots)")
        .expected(0, 2);
    b.option("--distances LIST", b->distances,
             "distances of the surfaces, in percent of the diagonal of MESH_A's AABB (default 0,0.1,1,5,10,20,40); 0 "
             "just touches, negative collides");
    Option poses = b.option("--poses FILE", b->poses,
                            "poses from a file for these meshes, with exact results if FILE_expected exists; without "
                            "FILE: the data folder's set with its own meshes");
    poses.expected(0, 1);
    b.whole("--count N", b->count, "poses per distance (default 100), or poses of the file (default: all)",
            {1, 100'000});
    b.option("--query,--ask LIST", b->ask,
             "queries: boolean (do they collide?), all (which triangles meet?), distance (default: all three)");
    b.only(), b.repeats("number of runs; each query's least time counts");
    b.csv("contender, query and distance"), b.shard("distances");
    b.plot("time against distance, one panel per query"), b.seed("the poses"), b.data("poses/");
    b.footer(
        "Examples:\n"
        "  oncollide-lab bench narrow                                     two generated knots, no files needed\n"
        "  oncollide-lab bench narrow cup.obj spoon.stl --distances 0,1,10 --plot narrow.svg\n"
        "  oncollide-lab bench narrow --poses --query boolean --only walk-6,fcl-obb,fcl-obbrss\n"
        "Every result is checked by exact arithmetic. In 'results', +k are k false positives and\n"
        "MISSED k is k missed collisions (of 'all': pairs of triangles). Exit code 70: oncollide missed a\n"
        "collision, or an exact result is wrong. Definitions for each contender: docs/notes/benchmark-methods.md.");
    b.prepare([poses](NarrowOptions& o) { o.use_poses = poses.given(); });
}

} // namespace oncollide::tools
