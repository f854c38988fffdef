// oncollide-lab bench avalanche: bodies slide down a hill until they rest, moved by the reference solver, and beside it
// by another library's physics.
#include "bench/common/benchmark.hpp"
#include "bench/contacts/avalanche_scene.hpp"
#include "bench/contacts/our_physics.hpp"
#include "cli/system.hpp"

#include <algorithm>

#include <oncollide/base/threads/parallel.hpp>

namespace oncollide::tools {
namespace {

struct AvalancheOptions : SharedOptions {
    int bodies = 10'000;
    std::optional<int> meshes{};
    int most_seconds = 60;
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
std::size_t lost_bodies(const AvalancheScene& scene, const PhysicsPeer& peer)
{
    std::vector<Eigen::Isometry3d> poses;
    peer.poses(poses);
    const Terrain& hill = std::get<Terrain>(scene.hill->data);
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

AvalancheEnd play(ResultTable& table, const std::string& who, const AvalancheScene& scene, PhysicsPeer& peer,
                  const PhysicsSettings& settings, int most_seconds)
{
    AvalancheEnd end;
    AvalancheSecond second;
    const int a_second = std::max(1, static_cast<int>(std::lround(1 / settings.dt)));
    int i = 1;
    for (; !end.rests && i * settings.dt <= most_seconds; ++i) {
        const PhysicsStep step = peer.step();
        second.add(step);
        end.rests = step.awake == 0;
        if (i % a_second == 0 || end.rests) {
            table.row(second.figures_of(who, i * settings.dt, lost_bodies(scene, peer)));
            second = {};
        }
    }
    end.lost = lost_bodies(scene, peer);
    AvalancheSecond rest; // the cost of a step when nothing moves any more
    for (int k = 0; end.rests && k < 20; ++k) rest.add(peer.step());
    if (end.rests) table.row(rest.figures_of(who + ", at rest", i * settings.dt, end.lost));
    return end;
}

int bench_avalanche(const AvalancheOptions& options)
{
    PhysicsContenders contenders = all_contenders().physics;
    if (options.only == "oncollide")
        contenders.all.clear();
    else
        contenders.keep(options.only);
    const int meshes = options.meshes.value_or(options.bodies / 20);
    const AvalancheScene scene = make_avalanche(options.bodies, meshes, options.seed);
    const Terrain& hill = std::get<Terrain>(scene.hill->data);
    const int threads = threads_of(options.threads);
    say("{}scene      {} shapes and {} concave meshes on a hill of {} triangles, seed {}\n",
        describe_program("avalanche"), grouped(std::uint64_t(options.bodies)), grouped(std::uint64_t(meshes)),
        grouped(2 * hill.cells()), options.seed);
    say("{:<11}the reference solver on manifolds, {} thread{}\n", "oncollide", threads, threads == 1 ? "" : "s");
    for (const PhysicsContender& c : contenders.all) say("{:<11}{}\n", c.name, c.what);
    print_missing(contenders.missing);
    say("\n");
    constexpr double density = 1000;
    std::vector<PhysicsBody> bodies = {{scene.hill.get(), Eigen::Isometry3d::Identity(), 0, Eigen::Vector3d::Zero()}};
    for (const ContactBody& body : scene.bodies) { // as boxes
        const Eigen::Vector3d squares = body.half.cwiseProduct(body.half);
        const double mass = 8 * body.half.prod() * density;
        const Eigen::Vector3d inertia(squares.y() + squares.z(), squares.z() + squares.x(), squares.x() + squares.y());
        bodies.push_back({body.geometry.get(), body.pose, mass, mass / 3 * inertia});
    }
    const PhysicsSettings settings;
    ResultTable table(options.csv, {20});
    AvalancheEnd ours;
    {
        const auto peer = make_our_physics(bodies, settings, threads);
        ours = play(table, "oncollide", scene, *peer, settings, options.most_seconds);
    }
    for (const PhysicsContender& c : contenders.all)
        play(table, c.name, scene, *c.make(bodies, settings), settings, options.most_seconds);
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
    b.whole("--bodies N", b->bodies, "shapes; the hill has about 100 triangles for each", {1, 1'000'000});
    b.whole("--meshes N", b->meshes, "concave meshes among them (default: one for 20 shapes)", {0, 1'000'000});
    b.whole("--seconds N", b->most_seconds, "longest simulated time", {1, 3600});
    b.only(), b.threads("of oncollide"), b.seed("the bodies and the hill"), b.csv("library and simulated second");
    b.footer(
        "Times are means over the steps of a simulated second, of 4 ms each; the last step of the second gives 'awake' "
        "(bodies), 'contacts', 'fastest' (m/s) and 'lost' (bodies below the hill or beside it). Exit code 70: a body "
        "of oncollide is lost, or still moves at the end.");
}

} // namespace oncollide::tools
