#include "bench/gpu/exact_frames.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/gl/walk/mesh_walks.hpp>
#include <oncollide/pipeline/refine/gpu_pairs.hpp>
#include <oncollide/pipeline/world/world_access.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/generators.hpp>

#include "common/statistics.hpp"

namespace oncollide::tools {
namespace {

struct ExactContender {
    std::string name;
    Settings settings;
};

std::vector<ExactContender> exact_contenders(const ExactContest& contest)
{
    std::vector<ExactContender> all{{"cpu, 1 thread", {}}};
    if (contest.threads > 1)
        all.push_back({fmt::format("cpu, {} threads", contest.threads), {.threads = contest.threads}});
    all.push_back({"gl, 1 thread", {.backend = BackendKind::gl, .gpu = contest.gpu}});
    if (contest.threads > 1)
        all.push_back({fmt::format("gl, {} threads", contest.threads),
                       {.backend = BackendKind::gl, .gpu = contest.gpu, .threads = contest.threads}});
    return all;
}

/// The work of the backend gl so far.
struct GpuWork {
    MeshWalkCounts gpu;
    GpuHostTimes host;

    GpuWork() = default;
    explicit GpuWork(const World& world) : gpu(WorldAccess::gpu_counts(world)), host(WorldAccess::gpu_host_times(world))
    {
    }
};

/// The work between two states, for each of `n` frames or calls.
Figures figures_of(const GpuWork& now, const GpuWork& before, double n)
{
    using C = MeshWalkCounts;
    using H = GpuHostTimes;
    const auto each = [&](auto member) { return double(now.gpu.*member - before.gpu.*member) / n; };
    const auto host = [&](double H::*member) { return (now.host.*member - before.host.*member) / n; };
    const double spread =
        host(&H::tasks_ms) + host(&H::sort_ms) + host(&H::trees_ms) + host(&H::fill_ms) + host(&H::take_ms);
    const double pairs = each(&C::pairs);
    return figures("gpu_pairs", pairs, "dispatches", each(&C::dispatches), "bytes_up", each(&C::bytes_up),
                   "tree_bytes_up", each(&C::tree_bytes), "bytes_down", each(&C::bytes_down), "gpu_box_rows",
                   each(&C::box_rows), "gpu_triangle_pairs", each(&C::triangle_pairs), "gpu_unsure_pairs",
                   each(&C::unsure_pairs), "upload_ms", each(&C::upload_ms), "prepare_ms", each(&C::prepare_ms),
                   "walk_ms", each(&C::walk_ms), "readback_ms", each(&C::readback_ms), "wait_ms", each(&C::wait_ms),
                   "host_tasks_ms", host(&H::tasks_ms), "host_sort_ms", host(&H::sort_ms), "host_trees_ms",
                   host(&H::trees_ms), "host_fill_ms", host(&H::fill_ms), "host_submit_ms", host(&H::submit_ms),
                   "host_meanwhile_ms", host(&H::meanwhile_ms), "host_take_ms", host(&H::take_ms), "host_rest_ms",
                   host(&H::rest_ms), "host_ns_per_pair", pairs > 0 ? 1e6 * spread / pairs : 0.0);
}

Figures joined(Figures all, const Figures& more)
{
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

/// At random poses within this distance (m) about a third of the pairs meet.
constexpr double reach = 1.2;

std::vector<double> random_poses(std::size_t count, std::uint64_t seed)
{
    std::vector<double> poses(16 * count);
    for (std::size_t i = 0; i < count; ++i) {
        Eigen::Vector4d q;
        Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
        for (int k = 0; k < 4; ++k) q[k] = u01(seed + i, 1, std::uint64_t(k)) - 0.5;
        pose.topLeftCorner<3, 3>() = Eigen::Quaterniond(q.normalized()).toRotationMatrix();
        for (int k = 0; k < 3; ++k) pose(k, 3) = reach * (2 * u01(seed + i, 2, std::uint64_t(k)) - 1);
        Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> row(&poses[16 * i]);
        row = pose;
    }
    return poses;
}

} // namespace

int exact_frames(const ExactContest& contest, const std::string& title, const Scene& scene, int every,
                 ResultTable& table, const std::function<bool()>& stop)
{
    constexpr int cold = 2; // frames in which trees grow and go up
    std::uint64_t hash = 0;
    int different = 0;
    for (const bool coherence : {true, false})
        for (const auto& [name, usual] : exact_contenders(contest)) {
            if (stop()) return different;
            Settings settings = usual;
            settings.coherence = coherence;
            Scene played = scene;
            Pipeline pipeline(played, WorldAccess::make(settings, MeshWalkOptions{.worth_pairs = 1}));
            Mover mover;
            double first_ms = 0, warm_ms = 0;
            std::uint64_t rows = 0, triangles = 0, candidates = 0;
            GpuWork before;
            int frames = 0;
            for (int frame = 0; frame < played.frames; frame += every, ++frames) {
                mover.move(played, frame);
                if (frames == cold) before = GpuWork(pipeline.world());
                const FrameView view = pipeline.step(played);
                if (frames == 0) first_ms = view.ms;
                if (frames < cold) continue;
                warm_ms += view.ms, candidates += view.pairs.size();
                rows += view.trees.node_pairs, triangles += view.trees.triangle_pairs;
            }
            if (hash == 0) hash = pipeline.hash();
            different += pipeline.hash() != hash;
            const double warm = std::max(frames - cold, 1);
            table.row(joined(figures("what", title, "backend", name + (coherence ? "" : ", every pair walked"),
                                     "renderer", contest.renderer, "frames", frames, "first_ms", first_ms, "warm_ms",
                                     warm_ms / warm, "pairs", double(candidates) / warm, "box_rows",
                                     double(rows) / warm, "triangle_pairs", double(triangles) / warm, "hash",
                                     Hex{pipeline.hash()}, "equal", pipeline.hash() == hash),
                             figures_of(GpuWork(pipeline.world()), before, warm)));
        }
    return different;
}

int exact_batches(const ExactContest& contest, std::size_t poses, ResultTable& table)
{
    const auto mesh =
        std::make_shared<const Geometry>(Geometry{"knot", make_torus_knot_mesh(2, 3, 0.6, 0.25, 0.1, 5000), {}});
    const std::vector<double> at = random_poses(poses, 1), origin = random_poses(1, 0);
    std::vector<Finding> first(poses), found(poses);
    int different = 0;
    for (const auto& [name, settings] : exact_contenders(contest)) {
        World world(settings);
        const std::vector<ModelId> models{world.models().add(mesh)};
        double ms[2];
        GpuWork before;
        for (double& of_call : ms) { // trees grow and go up in the first call
            before = GpuWork(world);
            const auto from = Clock::now();
            world.pairs().decide(PairOfColumns{{models, origin}, {models, at}}, found);
            of_call = milliseconds_since(from);
        }
        if (name == exact_contenders(contest).front().name) first = found;
        int unequal = 0;
        for (std::size_t i = 0; i < poses; ++i) unequal += found[i].verdict != first[i].verdict;
        different += unequal;
        table.row(joined(figures("what", fmt::format("{} poses of two meshes of 5,000 triangles", poses), "backend",
                                 name, "renderer", contest.renderer, "poses", poses, "meeting",
                                 std::ranges::count(found, Verdict::colliding, &Finding::verdict), "first_ms", ms[0],
                                 "ms", ms[1], "poses_per_s", 1e3 * double(poses) / ms[1], "equal", unequal == 0),
                         figures_of(GpuWork(world), before, 1)));
    }
    return different;
}

} // namespace oncollide::tools
