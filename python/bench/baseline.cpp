// The calls that overhead.py times, without Python: nanoseconds per call, as lines "NAME NS".
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include <oncollide/pipeline/world.hpp>

using namespace oncollide;

namespace {

double seconds = 0.2;

/// The least of five runs.
template <class Work>
void time(const char* name, double items, Work work)
{
    using Clock = std::chrono::steady_clock;
    const auto run = [&](long calls) {
        const auto begin = Clock::now();
        for (long i = 0; i < calls; ++i) work();
        return std::chrono::duration<double>(Clock::now() - begin).count();
    };
    long calls = 1;
    while (run(calls) < seconds / 10) calls *= 2;
    double least = 1e9;
    for (int i = 0; i < 5; ++i) least = std::min(least, run(calls) / double(calls));
    std::printf("%s %.1f\n", name, 1e9 * least / items);
}

Eigen::Isometry3d at(double x)
{
    return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0));
}

} // namespace

int main(int arguments, char** argument)
{
    if (arguments > 1) seconds = std::atof(argument[1]);
    const auto ball = std::make_shared<const Geometry>(Geometry{"ball", Shape(Sphere{1}), ""});
    World empty({.exact = ExactLevel::predicates}), world({.exact = ExactLevel::predicates});
    const ModelId model = world.models().add(ball);
    Bodies& bodies = world.bodies();
    const BodyId a = bodies.add({.model = model}), b = bodies.add({.model = model, .pose = at(3)});
    const Eigen::Isometry3d pose = at(3);
    const PlacedModel far{model, at(50)};
    std::vector<BodyId> many;
    std::vector<Eigen::Isometry3d> places;
    for (int i = 0; i < 10000; ++i)
        places.push_back(at(100 + 3 * i)), many.push_back(bodies.add({.model = model, .pose = places.back()}));
    volatile double sink = 0;

    time("bodies.is_static", 1, [&] { sink = sink + bodies.is_static(b); });
    time("bodies.pose", 1, [&] { sink = sink + bodies.pose(b)(0, 3); });
    time("bodies.set_pose", 1, [&] { bodies.set_pose(b, pose); });
    time("space.overlaps", 1, [&] { sink = sink + double(world.space().overlaps(far).size()); });
    time("pairs.distance", 1, [&] { sink = sink + world.pairs().distance(a, b).lower; });
    time("World.step", 1, [&] { sink = sink + double(empty.step().pairs.size()); });
    time("bodies.set_pose of many", 10000, [&] { bodies.set_pose(many, places); });

    constexpr std::size_t count = 100'000;
    std::vector<PairOfModels> batch;
    for (std::size_t i = 0; i < count; ++i) batch.push_back({{model, at(0)}, {model, at(3 + 1e-5 * double(i))}});
    std::vector<Finding> results(count);
    time("pairs.decide of many", count, [&] { world.pairs().decide(batch, results); });
    return sink > 1e300;
}
