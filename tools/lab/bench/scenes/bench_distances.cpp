// oncollide-lab bench distances: distances of small bodies to large environments, near and far, compared with FCL.
#include <algorithm>
#include <cmath>
#include <vector>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/pipeline/world.hpp>

#include "bench/scenes/environment_scenes.hpp"
#include "cli/progress.hpp"
#include "fcl/fcl_world.hpp"

namespace oncollide::tools {

namespace {

struct DistancesOptions : SharedOptions {
    EnvironmentChoice in{.bodies = 12};
    std::string distances = "0.1,1,5,10,25,50,100,200"; ///< percent of the environment's diagonal
    double tolerance = 0;                               ///< metres
};

using Eigen::Vector3d;

/// One environment, kind of bodies, and distance.
struct DistanceRow {
    double metres = 0, fcl_us = 0, our_us = 0;
    int differ = 0; ///< results of FCL outside oncollide's certified bounds
};

/// A scene whose body 0 is the environment, in both libraries. Both keep their trees.
class DistanceRace {
public:
    explicit DistanceRace(Scene& scene) : scene_(scene), fcl_(scene)
    {
        for (std::uint32_t g = 0; g < scene.geometries.size(); ++g)
            models_.push_back(world_.models().add(scene.geometries.share(g)));
        for (std::size_t i = 0; i < scene.size(); ++i)
            ids_.push_back(world_.bodies().add(
                {.model = models_[index(scene.geometry[i])], .pose = scene.poses[i], .is_static = i == 0}));
        const Aabb bounds = bounds_of(scene.geometries[index(scene.geometry[0])].data);
        middle_ = bounds.centre(), diagonal_ = bounds.diagonal();
    }

    DistanceRow at(double percent, const DistancesOptions& o)
    {
        DistanceRow row;
        const auto bodies = std::uint32_t(scene_.size() - 1);
        for (std::uint32_t body = 1; body <= bodies; ++body) {
            place(body, 0.01 * percent * diagonal_, o.in.seed);
            Distance ours;
            double fcl = 0;
            take_turns(2, body, [&](std::size_t k) {
                if (k == 0)
                    row.our_us += 1e3 / bodies * least_ms(o.repeats, [&] {
                                      ours = world_.pairs().distance(ids_[0], ids_[body], {.tolerance = o.tolerance});
                                  });
                else
                    row.fcl_us += 1e3 / bodies * least_ms(o.repeats, [&] { fcl = fcl_.distance({0, body}); });
            });
            row.metres += ours.upper / bodies;
            const double rounding = 1e-6 * (1 + ours.upper);
            row.differ += fcl < ours.lower - rounding || fcl > ours.upper + rounding;
        }
        return row;
    }

private:
    /// Places the body at about this distance from the environment, on a random side. Moves in steps that are certainly
    /// free; if these lead past the environment, moves towards its nearest point.
    void place(std::uint32_t body, double wanted, std::uint64_t seed)
    {
        const auto random = [&](std::uint64_t k) { return u01(seed, 1000 + body, k) - 0.5; };
        const Vector3d out = Vector3d(random(0), random(1), 0.2 + std::abs(random(2))).normalized();
        Eigen::Isometry3d pose = scene_.poses[body];
        pose.translation() = middle_ + Vector3d(random(3), random(4), 0) * 0.3 * diagonal_ + (diagonal_ + wanted) * out;
        double last = HUGE_VAL;
        for (int step = 0; step < 30; ++step) {
            world_.bodies().set_pose(ids_[body], pose);
            const Distance d = world_.pairs().distance(ids_[0], ids_[body], {.tolerance = 0.1 * wanted});
            if (d.lower <= 1.1 * wanted) break;
            const Vector3d back = d.lower < last ? out : Vector3d((d.point_b - d.point_a).normalized());
            pose.translation() -= (d.lower - wanted) * back;
            last = d.lower;
        }
        scene_.set_pose(SceneBodyId{body}, pose);
    }

    Scene& scene_;
    World world_;
    FclWorld fcl_;
    std::vector<ModelId> models_;
    std::vector<BodyId> ids_;
    Vector3d middle_;
    double diagonal_ = 0;
};

std::vector<double> percents_of(const std::string& list)
{
    std::vector<double> percents;
    for (const std::string& text : split(list)) {
        char* end = nullptr;
        percents.push_back(std::strtod(text.c_str(), &end));
        if (text.empty() || *end != 0 || !(percents.back() > 0 && percents.back() <= 1e4))
            usage(fmt::format("--distances {}: expected percentages above 0 and up to 10000, such as "
                              "0.1,10,200",
                              list));
    }
    return percents;
}

/// Distances of bodies to large environments, compared with FCL. Returns the exit code.
int bench_distances(const DistancesOptions& o)
{
    if (!(o.tolerance >= 0)) usage("bench distances: --tolerance must be 0 or more");
    const std::vector<double> percents = percents_of(o.distances);
    std::vector<EnvironmentScene> scenes = scenes_of(o.in, 1);
    const Shard shard = shard_from(o.shard);
    keep_part(shard, scenes, "environments with their bodies");
    say("{}{} bodies, one after the other; microseconds per query, warm, least of {} runs; tolerance {} m\n\n",
        describe_program("distances"), o.in.bodies, o.repeats, o.tolerance);
    ResultTable table(o.csv, {},
                      shard.line(fmt::format("bench distances, {}, distances {}, tolerance {}", o.in.work(),
                                             o.distances, o.tolerance)));
    for (const EnvironmentScene& which : scenes) {
        Scene scene = make_environment_scene(which);
        DistanceRace race(scene);
        for (const double percent : percents) {
            const DistanceRow row = race.at(percent, o);
            table.row(figures("environment", which.environment, "bodies", which.bodies_of, "percent", percent, "metres",
                              row.metres, "fcl_us", row.fcl_us, "us", row.our_us, "ratio", row.fcl_us / row.our_us,
                              "differ", row.differ));
        }
    }
    table.commit();
    return 0;
}

} // namespace

void add_distances(Arguments bench)
{
    Benchmark<DistancesOptions> b(bench, "distances", "Distances of bodies to buildings and terrains, near and far",
                                  bench_distances);
    add_environment_choice(b, b->in, 100'000);
    b.option("--distances LIST", b->distances,
             "in percent of the environment's diagonal (default 0.1,1,5,10,25,50,100,200)");
    b.option("--tolerance", b->tolerance,
             "largest difference of oncollide's bounds in metres (default 0); FCL's error for shapes is up to 1e-6")
        .length();
    b.repeats("number of runs; each query's least time counts"), b.csv("environment, bodies and distance");
    b.shard("environments with their bodies");
    b.footer("'percent' of the environment's diagonal; 'differ' counts results of FCL outside oncollide's certified "
             "bounds.\n"
             "Examples:\n"
             "  oncollide-lab bench distances --environments hills --distances 1,10,100 --bodies 30\n"
             "  oncollide-lab bench distances --environments campus --bodies-of shapes --csv distances.csv");
}

} // namespace oncollide::tools
