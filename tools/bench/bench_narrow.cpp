// How long does one question about two meshes take? oncollide beside the narrow phases of other libraries.
#include "bench/bench.hpp"
#include "bench/narrow_report.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/catalogue/mesh_generators.hpp>
#include <oncollide/scenes/files/mesh_file.hpp>

namespace oncollide::tools {
namespace {

namespace fs = std::filesystem;

constexpr int most_poses = 100'000;

std::vector<Ask> parse_asks(const std::string& list)
{
    std::array<bool, 3> wanted{};
    for (const std::string& part : split(list)) {
        const auto found = std::find(ask_names.begin(), ask_names.end(), part);
        if (found == ask_names.end())
            throw Error(ErrorKind::usage,
                        fmt::format("--ask {}: no such question; there are: {}", part, fmt::join(ask_names, ", ")));
        wanted[std::size_t(found - ask_names.begin())] = true;
    }
    std::vector<Ask> asks;
    for (Ask ask : {Ask::boolean, Ask::all, Ask::distance})
        if (wanted[std::size_t(ask)]) asks.push_back(ask);
    return asks;
}

std::vector<NarrowContender> chosen_contenders(const std::vector<NarrowContender>& all, const std::string& only)
{
    if (only.empty()) return all;
    std::vector<std::string> names;
    for (const NarrowContender& contender : all) names.push_back(contender.name);
    std::vector<NarrowContender> chosen;
    for (const std::string& name : split(only)) {
        const auto found = std::find(names.begin(), names.end(), name);
        if (found == names.end())
            throw Error(ErrorKind::usage,
                        fmt::format("--only {}: no such contender; this build has: {}", name, fmt::join(names, ", ")));
        const NarrowContender& contender = all[std::size_t(found - names.begin())];
        if (std::none_of(chosen.begin(), chosen.end(), [&](const auto& c) { return c.name == name; }))
            chosen.push_back(contender);
    }
    return chosen;
}

struct NamedMesh {
    std::string name;
    Mesh mesh;
};

/// The mesh without its triangles that have no area: whether these meet anything, the peers cannot agree.
NamedMesh with_area(NamedMesh named)
{
    const Mesh& mesh = named.mesh;
    if (mesh.zero_area == 0) return named;
    std::vector<Triangle> kept;
    for (const Triangle& t : mesh.triangles) {
        const std::vector<Eigen::Vector3d> corners{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
        if (make_mesh(named.name, corners, {{0, 1, 2}}).zero_area == 0) kept.push_back(t);
    }
    return {named.name, make_mesh(named.name + ", without triangles of no area", mesh.vertices, std::move(kept))};
}

/// Two files, the pair of the pose set, or generated.
std::array<NamedMesh, 2> open_meshes(const NarrowOptions& options)
{
    const auto load = [](const fs::path& path) { return with_area({path.stem().string(), load_mesh(path)}); };
    if (options.meshes.size() == 2) return {load(options.meshes[0]), load(options.meshes[1])};
    if (options.use_poses) {
        const PoseSet set = pose_set(data_folder(options.data));
        return {load(set.mesh_a), load(set.mesh_b)};
    }
    return {NamedMesh{"knot-3-4", make_torus_knot_mesh(3, 4, 1, 0.4, 0.18, 5082)},
            NamedMesh{"knot-2-3", make_torus_knot_mesh(2, 3, 1, 0.4, 0.18, 5144)}};
}

/// Poses of a file, with the exact answers beside it when there are any.
NarrowCourse read_course(const NarrowOptions& options)
{
    std::vector<KnownPose> poses =
        read_known_poses(options.poses.empty() ? pose_set(data_folder(options.data)).poses : fs::path(options.poses));
    if (options.count && std::size_t(*options.count) < poses.size()) poses.resize(std::size_t(*options.count));
    return course_of(std::move(poses));
}

void check(const NarrowOptions& options)
{
    const auto refuse = [](const std::string& why) { throw Error(ErrorKind::usage, why); };
    if (options.meshes.size() == 1) refuse(fmt::format("{}: a second mesh is missing", options.meshes[0]));
    if (!options.poses.empty() && options.meshes.empty())
        refuse(fmt::format("--poses {}: needs the two meshes that it is about: MESH_A MESH_B", options.poses));
    if (options.use_poses && options.poses.empty() && !options.meshes.empty())
        refuse("--poses: the data folder's poses have meshes of their own; name a pose file or no meshes");
    if (options.use_poses && !options.distances.empty()) refuse("--distances: the poses of a file have their own");
    if (options.repeats < 1 || options.repeats > 1000)
        refuse(fmt::format("--repeats {}: must be from 1 to 1000", options.repeats));
    if (options.count && (*options.count < 1 || *options.count > most_poses))
        refuse(fmt::format("--count {}: must be from 1 to {}", *options.count, most_poses));
    if (!options.csv.empty() && options.csv == options.plot)
        refuse(fmt::format("--csv and --plot both go to {}", options.csv));
}

void print_settings(const NarrowOptions& options, const NarrowResult& result, const NarrowContenders& contenders)
{
    say("{}", describe_program("narrow phase alone"));
    for (const MissingPeer& peer : contenders.missing)
        say("{:<11}not in this build (Debian: {})\n", peer.library, peer.package);
    const auto colliding = std::count(result.truth.colliding.begin(), result.truth.colliding.end(), true);
    say("meshes     {} ({} triangles), {} ({})\n"
        "poses      {}, {} colliding{}; the least of {} repeats of each query, after a pass to warm up\n",
        result.mesh_a, grouped(result.triangles_a), result.mesh_b, grouped(result.triangles_b),
        grouped(result.workload.poses.size()), grouped(std::uint64_t(colliding)),
        options.use_poses ? "" : fmt::format(", seed {}", options.seed), options.repeats);
    std::cout.flush();
}

/// Takes out those that would crash on meshes of so few triangles, and says so.
void leave_out_fragile(std::vector<NarrowContender>& contenders, std::size_t triangles)
{
    std::erase_if(contenders, [&](const NarrowContender& contender) {
        if (triangles < contender.least)
            say("left out   {}: crashes on meshes of fewer than {} triangles\n", contender.name, contender.least);
        return triangles < contender.least;
    });
}

} // namespace

int bench_narrow(const NarrowOptions& options)
{
    check(options);
    NarrowResult result;
    result.asks = parse_asks(options.ask.empty() ? "boolean,all,distance" : options.ask);
    const std::vector<double> percents =
        parse_distances(options.distances.empty() ? "0,0.1,1,5,10,20,40" : options.distances);
    NarrowContenders contenders = narrow_contenders();
    contenders.all = chosen_contenders(contenders.all, options.only);
    const auto answers_any = [&](const NarrowContender& contender) {
        return std::any_of(result.asks.begin(), result.asks.end(), [&](Ask ask) { return answers(contender, ask); });
    };
    if (std::none_of(contenders.all.begin(), contenders.all.end(), answers_any))
        throw Error(ErrorKind::usage, fmt::format("--only {}: answers none of --ask {}", options.only, options.ask));
    std::optional<OutputFile> csv, plot;
    if (!options.csv.empty()) csv.emplace(options.csv);
    if (!options.plot.empty()) plot.emplace(options.plot);

    const std::array<NamedMesh, 2> meshes = open_meshes(options);
    const Mesh &a = meshes[0].mesh, &b = meshes[1].mesh;
    result.mesh_a = meshes[0].name, result.triangles_a = a.triangles.size();
    result.mesh_b = meshes[1].name, result.triangles_b = b.triangles.size();
    result.diagonal = a.bounds.diagonal(), result.seed = options.seed;
    result.workload = options.use_poses
                          ? read_course(options)
                          : make_course(a, b, percents, std::size_t(options.count.value_or(100)), options.seed);
    result.truth = judge(a, b, result.workload, result.asks);
    print_settings(options, result, contenders);
    leave_out_fragile(contenders.all, std::min(result.triangles_a, result.triangles_b));
    result.rows = race(a, b, result.workload, result.truth, contenders.all, result.asks, options.repeats);
    print_narrow(result);
    if (csv) write_narrow_csv(*csv, result), csv->commit();
    if (plot) draw_narrow_plot(*plot, result), plot->commit();
    return broken_promise(result) ? int(ErrorKind::internal) : 0;
}

} // namespace oncollide::tools
