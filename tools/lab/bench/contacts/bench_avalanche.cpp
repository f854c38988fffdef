// oncollide-lab bench avalanche: bodies slide down a hill until they rest, moved by the reference solver, and beside it
// by another library's physics.
#include "bench/common/benchmark.hpp"
#include "bench/contacts/our_physics.hpp"
#include "bench/contacts/pose_record.hpp"
#include "cli/system.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/samples/bodies_above.hpp>
#include <oncollide/samples/catalogue.hpp>

namespace oncollide::tools {
namespace {

struct AvalancheOptions : SharedOptions {
    int bodies = 10'500, most_seconds = 60, record_every = 10;
    std::string record; ///< scene file; empty: none
};

/// Means over the steps of one second.
struct AvalancheSecond {
    int steps = 0;
    PhysicsStep sum; ///< of the steps; awake, contacts and fastest: of the last step

    void add(const PhysicsStep& step)
    {
        ++steps;
        const double detection = sum.detection_ms + step.detection_ms, solver = sum.solver_ms + step.solver_ms;
        sum = step, sum.detection_ms = detection, sum.solver_ms = solver;
    }
    Figures figures_of(const std::string& who, double time, std::size_t lost) const
    {
        const double n = std::max(steps, 1);
        return figures("who", who, "s", time, "awake", sum.awake, "contacts", sum.contacts, "detection_ms",
                       sum.detection_ms / n, "solver_ms", sum.solver_ms / n, "fastest", sum.fastest, "lost", lost);
    }
};

/// Bodies whose middle is below the hill by more than a concave body's hole may let it be, or beside the hill.
std::size_t lost_bodies(const Terrain& hill, std::span<const Eigen::Isometry3d> poses)
{
    return static_cast<std::size_t>(std::count_if(poses.begin() + 1, poses.end(), [&](const auto& pose) {
        const Eigen::Vector3d p = pose.translation();
        constexpr double deep = 0.1;
        return !(p.z() > height_at(hill, p.x(), p.y()) - deep);
    }));
}

struct AvalancheEnd {
    bool rests = false;
    std::size_t lost = 0;
};

/// @param watch  gets the poses of each step, and its number from 0: the start
AvalancheEnd play(ResultTable& table, const std::string& who, const Terrain& hill, PhysicsPeer& peer,
                  const AvalancheOptions& options,
                  const std::function<void(int, std::span<const Eigen::Isometry3d>)>& watch = {})
{
    AvalancheEnd end;
    AvalancheSecond second;
    std::vector<Eigen::Isometry3d> poses;
    const auto look = [&](int i) {
        peer.poses(poses);
        if (watch) watch(i, poses);
    };
    const double dt = PhysicsSettings{}.dt;
    const int a_second = static_cast<int>(std::lround(1 / dt));
    look(0);
    int i = 1;
    for (; !end.rests && i * dt <= options.most_seconds; ++i) {
        const PhysicsStep step = peer.step();
        second.add(step);
        end.rests = step.awake == 0;
        look(i);
        if (i % a_second == 0 || end.rests) {
            end.lost = lost_bodies(hill, poses);
            table.row(second.figures_of(who, i * dt, end.lost));
            second = {};
        }
    }
    AvalancheSecond rest; // the cost of a step when nothing moves any more
    for (int k = 0; end.rests && k < 20; ++k) rest.add(peer.step());
    if (end.rests) table.row(rest.figures_of(who + ", at rest", i * dt, end.lost));
    return end;
}

std::vector<PhysicsBody> bodies_of(const Scene& scene)
{
    constexpr double density = 1000;
    std::vector<PhysicsBody> bodies;
    for (std::size_t i = 0; i < scene.size(); ++i) {
        const Geometry& geometry = scene.geometries[index(scene.geometry[i])];
        bodies.push_back({&geometry, scene.start_pose(i), 0, Eigen::Vector3d::Zero()});
        if (scene.is_static[i]) continue;
        const Eigen::Vector3d half = bounds_of(geometry).half_extent(), squares = half.cwiseProduct(half); // as a box
        const Eigen::Vector3d pairs(squares.y() + squares.z(), squares.z() + squares.x(), squares.x() + squares.y());
        bodies.back().mass = 8 * half.prod() * density, bodies.back().inertia = bodies.back().mass / 3 * pairs;
    }
    return bodies;
}

int bench_avalanche(const AvalancheOptions& options)
{
    PhysicsContenders contenders = all_contenders().physics;
    if (options.only == "oncollide")
        contenders.all.clear();
    else
        contenders.keep(options.only);
    const Scene scene = make_scene("avalanche", {.bodies = options.bodies, .seed = options.seed});
    const Terrain& hill = std::get<Terrain>(scene.geometries[0].data);
    const int threads = threads_of(options.threads);
    say("{}scene      {} bodies of all kinds on a hill of {} triangles, seed {}\n", describe_program("avalanche"),
        grouped(std::uint64_t(options.bodies)), grouped(2 * hill.cells()), options.seed);
    say("{:<11}the reference solver on manifolds, {} thread{}\n", "oncollide", threads, threads == 1 ? "" : "s");
    for (const PhysicsContender& c : contenders.all) say("{:<11}{}\n", c.name, c.what);
    print_missing(contenders.missing);
    say("\n");
    const std::vector<PhysicsBody> bodies = bodies_of(scene);
    const PhysicsSettings settings;
    ResultTable table(options.csv, {20});
    AvalancheEnd ours;
    {
        PoseRecord record(scene);
        ours = play(table, "oncollide", hill, *make_our_physics(bodies, settings, threads), options,
                    [&](int i, std::span<const Eigen::Isometry3d> poses) {
                        if (!options.record.empty() && i % options.record_every == 0) record.add(poses);
                    });
        if (!options.record.empty()) record.save(options.record);
    }
    for (const PhysicsContender& c : contenders.all) play(table, c.name, hill, *c.make(bodies, settings), options);
    table.commit();
    if (!ours.rests) say("\nBodies still move after {} s.\n", options.most_seconds);
    if (ours.lost > 0) say("\n{} bodies are below the hill or beside it.\n", ours.lost);
    return code_of(!ours.rests || ours.lost > 0);
}

} // namespace

void add_avalanche(Arguments bench)
{
    Benchmark<AvalancheOptions> b(bench, "avalanche",
                                  "Bodies of all shapes slide down a hill until they rest, moved by the reference "
                                  "solver, and by Bullet beside it",
                                  bench_avalanche);
    b.whole("--bodies N", b->bodies, "one in 21 is a concave mesh; the hill has about 100 triangles for each",
            {1, 100'000});
    b.whole("--seconds N", b->most_seconds, "longest simulated time", {1, 3600});
    b.output("--record", "SCENE.json", b->record,
             "write the motion that oncollide finds as a scene for 'oncollide run'; a file beside it holds the poses");
    b.whole("--record-every K", b->record_every, "steps between its frames", {1, 1'000'000});
    b.only(), b.threads("of oncollide"), b.seed("the bodies and the hill"), b.csv("library and simulated second");
    b.footer(fmt::format(
        "Times are means over the steps of a simulated second, of {:.0f} ms each; the last step of the second gives "
        "'awake' (bodies), 'contacts', 'fastest' (m/s) and 'lost' (bodies below the hill or beside it). Exit code 70: "
        "a body of oncollide is lost, or still moves at the end.",
        1000 * PhysicsSettings{}.dt));
}

} // namespace oncollide::tools
