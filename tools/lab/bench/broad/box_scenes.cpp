#include "bench/broad/box_scenes.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

constexpr double grid = 0x1p-13; // metres
constexpr std::string_view scene_names[] = {"brown",          "large",
                                            "mixed",          "flat",
                                            "clustered",      "static",
                                            "giant",          "jump",
                                            "freefall-cubes", "freefall-assorted",
                                            "brownian-cubes", "brownian-assorted",
                                            "gravity-cubes",  "gravity-assorted"};

/// The data from which a scene's boxes are made.
struct Swarm {
    std::uint64_t seed = 0;
    double side = 0; ///< the room is [0, side]^3
    std::vector<Vector3d> position, half, velocity;
};

Vector3d uniform(std::uint64_t seed, std::uint64_t index, std::uint64_t first)
{
    return {u01(seed, index, first), u01(seed, index, first + 1), u01(seed, index, first + 2)};
}

/// Reflects p back into [0, side]; true if it was outside.
bool reflect(double& p, double side)
{
    if (p >= 0 && p <= side) return false;
    p = p < 0 ? -p : 2 * side - p;
    return true;
}

Swarm make_swarm(std::size_t count, std::uint64_t seed, double side)
{
    Swarm swarm{seed, side, {}, {}, {}};
    for (std::uint64_t i = 0; i < count; ++i) {
        swarm.half.push_back(0.5 * (Vector3d::Constant(0.5) + uniform(seed, i, 0)));
        swarm.position.push_back(side * uniform(seed, i, 10));
    }
    return swarm;
}

/// Every axis in `axes` moves randomly by up to 0.1 per frame.
void walk(Swarm& swarm, std::uint64_t frame, int axes)
{
    for (std::uint64_t i = 0; i < swarm.position.size(); ++i)
        for (int axis = 0; axis < axes; ++axis) {
            double& p = swarm.position[i][axis];
            p += 0.2 * (u01(swarm.seed + 1000 + frame, i, static_cast<std::uint64_t>(axis)) - 0.5);
            reflect(p, swarm.side);
        }
}

void drift(Swarm& swarm, std::span<const std::uint32_t> movers)
{
    for (std::uint32_t i : movers)
        for (int axis = 0; axis < 3; ++axis) {
            swarm.position[i][axis] += swarm.velocity[i][axis];
            if (reflect(swarm.position[i][axis], swarm.side)) swarm.velocity[i][axis] *= -1;
        }
}

void place(BoxScene& scene, const Swarm& swarm)
{
    for (std::uint32_t i : scene.moved) scene.boxes[i] = box_on_grid(swarm.position[i], swarm.half[i]);
}

BoxScene scene_of(const Swarm& swarm)
{
    BoxScene scene;
    for (std::size_t i = 0; i < swarm.position.size(); ++i)
        scene.boxes.push_back(box_on_grid(swarm.position[i], swarm.half[i]));
    scene.is_static.assign(swarm.position.size(), 0);
    return scene;
}

/// All boxes move. move(swarm, scene) changes the positions for scene.frame.
template <class Move>
BoxScene moving(Swarm&& made, Move move)
{
    const auto swarm = std::make_shared<Swarm>(std::move(made));
    BoxScene scene = scene_of(*swarm);
    scene.moved.resize(scene.boxes.size());
    std::iota(scene.moved.begin(), scene.moved.end(), 0u);
    scene.next = [swarm, move](BoxScene& s) {
        move(*swarm, s);
        place(s, *swarm);
    };
    return scene;
}

BoxScene walking(Swarm&& swarm, int axes = 3)
{
    return moving(std::move(swarm), [axes](Swarm& s, const BoxScene& scene) { walk(s, scene.frame, axes); });
}

/// Every `stride`-th box moves at a constant velocity.
BoxScene drifting(Swarm&& swarm, std::size_t stride)
{
    for (std::size_t i = 0; i < swarm.position.size(); ++i)
        swarm.velocity.push_back(0.4 * (uniform(swarm.seed, i, 20) - Vector3d::Constant(0.5)));
    BoxScene scene = moving(std::move(swarm), [](Swarm& s, const BoxScene& scene) { drift(s, scene.moved); });
    std::erase_if(scene.moved, [&](std::uint32_t i) { return i % stride != 0; });
    return scene;
}

/// Edges from 0.1 to 10, half of them below 0.2: 0.1 * 100^(u^3), up to two thirds less along single axes.
Swarm mixed_sizes(Swarm swarm)
{
    for (std::uint64_t i = 0; i < swarm.half.size(); ++i) {
        const double edge = 0.1 * std::pow(100, std::pow(u01(swarm.seed, i, 30), 3));
        const Vector3d edges = edge * (Vector3d::Ones() - 2.0 / 3 * uniform(swarm.seed, i, 31));
        swarm.half[i] = 0.5 * edges.cwiseMax(0.1);
    }
    return swarm;
}

Swarm in_one_plane(Swarm swarm)
{
    for (Vector3d& p : swarm.position) p.z() = 1;
    return swarm;
}

/// Clusters of about a thousand boxes, dense in the middle (standard deviation 4), far apart from each other.
Swarm clustered(Swarm swarm)
{
    const std::uint64_t clusters = swarm.position.size() / 1000 + 1;
    const double margin = std::min(12.0, 0.5 * swarm.side);
    for (std::uint64_t i = 0; i < swarm.position.size(); ++i) {
        const Vector3d centre =
            Vector3d::Constant(margin) + (swarm.side - 2 * margin) * uniform(swarm.seed + 1, i % clusters, 0);
        const Vector3d sum = uniform(swarm.seed, i, 30) + uniform(swarm.seed, i, 40) + uniform(swarm.seed, i, 50);
        const Vector3d from_centre = 8 * (sum - Vector3d::Constant(1.5));
        swarm.position[i] = (centre + from_centre).cwiseMax(0.0).cwiseMin(swarm.side);
    }
    return swarm;
}

/// A thousand moving boxes (a tenth of the boxes if that is fewer) among static boxes.
BoxScene mostly_static(Swarm&& swarm)
{
    const std::size_t count = swarm.position.size();
    BoxScene scene = drifting(std::move(swarm), std::max<std::size_t>(10, count / 1000));
    scene.is_static.assign(count, 1);
    for (std::uint32_t mover : scene.moved) scene.is_static[mover] = 0;
    return scene;
}

/// All boxes take a new position in every frame.
BoxScene jumping(Swarm&& swarm)
{
    return moving(std::move(swarm), [](Swarm& s, const BoxScene& scene) {
        for (std::uint64_t i = 0; i < s.position.size(); ++i)
            s.position[i] = s.side * uniform(s.seed + 1000 + scene.frame, i, 0);
    });
}

/// The first box is as large as the room.
Swarm one_giant(Swarm swarm)
{
    swarm.position[0] = Vector3d::Constant(0.5 * swarm.side), swarm.half[0] = swarm.position[0];
    return swarm;
}

BoxScene make(std::string_view name, std::size_t count, std::uint64_t seed)
{
    const auto swarm = [&](double room) {
        return make_swarm(count, seed, std::cbrt(room * static_cast<double>(count)));
    };
    if (name == "brown") return walking(swarm(4));
    if (name == "large") return drifting(swarm(40), 100);
    if (name == "mixed") return walking(mixed_sizes(swarm(40)));
    if (name == "flat") return walking(in_one_plane(make_swarm(count, seed, std::sqrt(2.0 * double(count)))), 2);
    if (name == "clustered") return walking(clustered(swarm(40)));
    if (name == "giant") return walking(one_giant(swarm(4)));
    if (name == "jump") return jumping(swarm(4));
    if (name == "static") return mostly_static(swarm(4));
    const std::size_t dash = name.find('-');
    return make_broadmark_scene(name.substr(0, dash), name.substr(dash + 1) == "assorted", count, seed);
}

} // namespace

std::span<const std::string_view> box_scene_names()
{
    return scene_names;
}

Aabb box_on_grid(const Vector3d& position, const Vector3d& half)
{
    const Eigen::Array3d low = 2 * ((position - half).array() / (2 * grid)).floor();
    const Eigen::Array3d high = low + 2 * (half.array() / grid).floor() + 1;
    Aabb box;
    box.min = (low * grid).matrix();
    box.max = (high * grid).matrix();
    return box;
}

BoxScene make_box_scene(std::string_view name, std::size_t count, std::uint64_t seed)
{
    if (std::find(std::begin(scene_names), std::end(scene_names), name) == std::end(scene_names))
        throw Error(ErrorKind::usage,
                    fmt::format("unknown scene '{}' of boxes{}, or a recording FILE.aabbs", name,
                                valid_names(name, {std::begin(scene_names), std::end(scene_names)}, "valid")));
    if (count < 1 || count > most_boxes)
        throw Error(ErrorKind::usage, fmt::format("{} boxes: must be from 1 to {}", count, most_boxes));
    BoxScene scene = make(name, count, seed);
    scene.name = name;
    return scene;
}

void advance(BoxScene& scene)
{
    ++scene.frame;
    scene.next(scene);
}

PairSet summarise(std::span<const BodyPair> pairs)
{
    PairSet set{pairs.size(), 0};
    for (const BodyPair& pair : pairs) {
        const std::uint64_t a = std::min(pair.a, pair.b), b = std::max(pair.a, pair.b);
        set.hash += splitmix(a << 32 | b);
    }
    return set;
}

std::optional<PairSet> published_result(std::string_view scene, std::size_t count, std::uint64_t frame)
{
    struct Row {
        std::string_view scene;
        std::size_t count;
        std::uint64_t frame;
        PairSet pairs;
    };
    constexpr Row rows[] = {
        {"brown", 1'000, 60, {938, 0x2c42a71ad89f921f}},       {"brown", 10'000, 40, {9'220, 0x2b7a529b3d0c9a40}},
        {"brown", 100'000, 12, {97'769, 0x0cb2b436b0d7b4d0}},  {"brown", 1'000'000, 8, {989'922, 0x4421aa43f767f614}},
        {"large", 10'000, 40, {911, 0x2e9e30fac95e15c8}},      {"large", 100'000, 12, {9'888, 0x2a0b027477ec4f80}},
        {"large", 1'000'000, 8, {99'450, 0x91ed0d384cbf2a29}},
    };
    for (const Row& row : rows)
        if (row.scene == scene && row.count == count && row.frame == frame) return row.pairs;
    return {};
}

} // namespace oncollide::tools
