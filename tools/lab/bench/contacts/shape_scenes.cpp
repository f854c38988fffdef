#include "bench/contacts/shape_scenes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include <oncollide/samples/generators.hpp>

#include "bench/contacts/shape_bodies.hpp"
#include "common/text.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Kinds = std::vector<ShapeKind>;

std::shared_ptr<const Geometry> shared(GeometryData data)
{
    return std::make_shared<const Geometry>(Geometry{"", std::move(data), {}});
}

ContactBody floor_body()
{
    return {.geometry = shared(Shape(Box{{60, 60, 1}})), .pose = Isometry3d(Eigen::Translation3d(0, 0, -1))};
}

/// A body that moves. Nothing plays these scenes, so all have the mass of one box.
ContactBody mover(std::shared_ptr<const Geometry> geometry, const Isometry3d& pose)
{
    return {.geometry = std::move(geometry), .pose = pose, .half = {0.1, 0.1, 0.1}};
}

/// Shapes of these kinds in turns, each several times, with their models.
class ShapePool {
public:
    ShapePool(Kinds kinds, std::uint64_t seed, int points = 0) : kinds_(std::move(kinds))
    {
        for (std::size_t i = 0; i < of_a_kind * kinds_.size(); ++i) {
            ShapeDice dice(seed, i);
            geometries_.push_back(shared(draw_shape(kind(i), dice, points)));
            models_.push_back(std::make_unique<Model>(geometries_.back()));
        }
    }
    ShapeKind kind(std::size_t i) const { return kinds_[i % kinds_.size()]; }
    const std::shared_ptr<const Geometry>& geometry(std::size_t i) const { return geometries_[i % geometries_.size()]; }
    Model& model(std::size_t i) { return *models_[i % models_.size()]; }

private:
    static constexpr std::size_t of_a_kind = 64;
    Kinds kinds_;
    std::vector<std::shared_ptr<const Geometry>> geometries_;
    std::vector<std::unique_ptr<Model>> models_;
};

/// Five steps around a small circle, each `stride` long, with a rotation to and fro; each body on its own plane.
ContactSteps circling(const ContactScene& scene, std::string mode, double stride)
{
    constexpr int count = 5;
    const double radius = stride / (2 * std::sin(M_PI / count));
    ContactSteps steps{.mode = std::move(mode), .steps = std::vector<Poses>(count)};
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const ContactBody& body = scene.bodies[i];
        steps.first.push_back(body.pose);
        ShapeDice dice(29, i);
        const Quaterniond plane = dice.rotation();
        const double phase = dice.between(0, 2 * M_PI);
        for (int k = 0; k < count; ++k) {
            const double angle = phase + 2 * M_PI * k / count;
            const Vector3d along = radius * (plane * Vector3d(std::cos(angle), std::sin(angle), 0));
            Isometry3d pose = body.pose;
            if (!body.half.isZero(0)) {
                pose.translation() += along;
                // Points 0.2 m from the origin move as far again.
                pose.linear() = Quaterniond(Eigen::AngleAxisd(along.norm() / 0.2, along.normalized()) * pose.linear())
                                    .normalized()
                                    .toRotationMatrix();
            }
            steps.steps[static_cast<std::size_t>(k)].push_back(pose);
        }
    }
    return steps;
}

ContactScene in_modes(ContactScene scene)
{
    scene.modes = {circling(scene, "moving", 2e-3), circling(scene, "slow", 1e-4)};
    scene.modes.push_back({.mode = "rest", .first = scene.modes.front().first, .steps = std::vector<Poses>(5)});
    return scene;
}

/// Cell sizes of a layer along one axis: the sum of the first k is where cell k begins.
std::vector<double> starts_of(std::size_t cells, ShapeDice& dice, std::vector<double>& sizes)
{
    constexpr std::array<double, 4> widths{0.2, 0.28, 0.36, 0.44};
    std::vector<double> starts{0};
    sizes.clear();
    for (std::size_t k = 0; k < cells; ++k)
        sizes.push_back(widths[dice.below(widths.size())]), starts.push_back(starts.back() + sizes.back());
    for (double& start : starts) start -= starts.back() / 2;
    return starts;
}

/// Layers of boxes. Each layer is a grid with its own sizes of cells, so a box stands on about four; some boxes are
/// lower than their layer, and some stand close to their neighbours.
ContactScene pile_of_boxes(int count)
{
    ContactScene scene{.name = fmt::format("pile-boxes-{}", count),
                       .what = fmt::format("{} boxes in layers, each on about four others, 1.5 mm deep, turned by up "
                                           "to 0.3 degrees",
                                           grouped(std::uint64_t(count)))};
    scene.bodies.push_back(floor_body());
    std::map<std::array<double, 3>, std::shared_ptr<const Geometry>> boxes;
    const auto side = static_cast<std::size_t>(std::ceil(std::cbrt(count)));
    constexpr double deep = 1.5e-3, close = 7e-4, apart = 3e-3;
    constexpr std::array<double, 3> heights{0.18, 0.26, 0.34};
    double bottom = 0;
    for (std::size_t layer = 0; scene.bodies.size() <= static_cast<std::size_t>(count); ++layer) {
        ShapeDice dice(17, layer);
        std::vector<double> wide, long_;
        const std::vector<double> x = starts_of(side, dice, wide), y = starts_of(side, dice, long_);
        const double height = heights[dice.below(heights.size())];
        for (std::size_t i = 0; i < side * side && scene.bodies.size() <= static_cast<std::size_t>(count); ++i) {
            const std::size_t c = i % side, r = i / side;
            const auto joint = [&] { return dice.chance(0.6) ? close : -apart; };
            const double top = dice.chance(0.2) ? 0.8 * height : height;
            const Vector3d size(wide[c] + joint(), long_[r] + joint(), top + deep);
            auto& box = boxes[{size.x(), size.y(), size.z()}];
            if (!box) box = shared(Shape(Box{size / 2}));
            Isometry3d pose(dice.tilt(0.005));
            pose.translation() = Vector3d(x[c] + wide[c] / 2, y[r] + long_[r] / 2, bottom + top / 2);
            scene.bodies.push_back(mover(box, pose));
        }
        bottom += height;
    }
    return in_modes(std::move(scene));
}

/// Shapes that lie on each other as ShapeHeap lets them.
ContactScene heap(const char* of, const char* what, const Kinds& kinds, int count)
{
    ContactScene scene{.name = fmt::format("pile-{}-{}", of, count),
                       .what = fmt::format("{} {}, each of which has slid to its lowest place, 2 mm into the others",
                                           grouped(std::uint64_t(count)), what)};
    scene.bodies.push_back(floor_body());
    ShapePool pool(kinds, 31);
    ShapeHeap shapes(0.09 * std::sqrt(count) + 0.3, 2e-3);
    for (int i = 0; i < count; ++i) {
        const auto k = static_cast<std::size_t>(i);
        ShapeDice dice(41, k);
        const Quaterniond rotation = dice.rotation();
        const double x = dice.between(-1, 1), y = dice.between(-1, 1);
        scene.bodies.push_back(mover(pool.geometry(k), shapes.add(pool.model(k), rotation, x, y)));
    }
    return in_modes(std::move(scene));
}

/// Shapes that lie on hills, one beside the other, as a terrain or as a mesh of the same triangles.
ContactScene on_ground(bool as_mesh, int count)
{
    const auto side = static_cast<std::uint32_t>(std::ceil(std::sqrt(count)));
    const std::uint32_t cells = 7 * side;
    const double spacing = 0.25;
    const Terrain terrain = make_hills(cells, cells, spacing, 0.08 * cells * spacing, 5);
    ContactScene scene{.name = fmt::format("{}-shapes-{}", as_mesh ? "mesh" : "terrain", count),
                       .what = fmt::format("{} boxes, spheres, capsules and hulls lie on a {} of {} triangles, 2 mm "
                                           "deep",
                                           grouped(std::uint64_t(count)), as_mesh ? "static mesh" : "terrain",
                                           grouped(std::uint64_t{2} * cells * cells))};
    scene.bodies.push_back({.geometry = as_mesh ? shared(mesh_of(terrain)) : shared(terrain)});
    ShapePool pool({ShapeKind::box, ShapeKind::sphere, ShapeKind::capsule, ShapeKind::hull}, 37);
    for (int i = 0; i < count; ++i) {
        const auto k = static_cast<std::size_t>(i);
        ShapeDice dice(43, k);
        const Eigen::Vector2d cell(i % int(side), i / int(side));
        const double x = dice.between(0.4, 0.6), y = dice.between(0.4, 0.6), yaw = dice.between(-M_PI, M_PI);
        const Eigen::Vector2d at = 7 * spacing * (cell + Eigen::Vector2d(x, y));
        scene.bodies.push_back(
            mover(pool.geometry(k), lie_on(terrain, pool.model(k), at, yaw, pool.kind(k) == ShapeKind::capsule, 2e-3)));
    }
    return in_modes(std::move(scene));
}

/// Where b touches a: from a random direction, or a third of the time along one of a's axes, with b's axes along a's.
/// They overlap by up to 3 mm along the way on which b came.
Isometry3d touching(Model& a, const Isometry3d& at_a, Model& b, ShapeDice& dice)
{
    const bool aligned = dice.chance(1.0 / 3);
    Vector3d from = dice.direction();
    Isometry3d pose(dice.rotation());
    if (aligned) {
        const auto axis = static_cast<Eigen::Index>(dice.below(3));
        from = dice.tilt(0.01) * Vector3d(at_a.linear().col(axis));
        pose = Isometry3d(dice.tilt(0.01) * at_a.linear());
    }
    const double aside = dice.between(0, 0.05), start = 2 * (a.reach() + b.reach());
    pose.translation() = at_a.translation() + start * from + aside * from.unitOrthogonal();
    pose.translation() -=
        (way_until_touching(a.convex(), at_a, b.convex(), pose, -from) + dice.between(1e-4, 3e-3)) * from;
    return pose;
}

constexpr int hull_points = 20; ///< of a single pair

std::string pair_name(ShapeKind a, ShapeKind b)
{
    const auto title = [](ShapeKind k) {
        return k == ShapeKind::hull ? fmt::format("hull{}", hull_points) : std::string(name_of(k));
    };
    return fmt::format("pair-{}-{}", title(a), title(b));
}

ContactScene single_pairs(ShapeKind a, ShapeKind b, int count)
{
    ContactScene scene{
        .name = pair_name(a, b),
        .what = fmt::format("one pair at a time, of {} that touch, new in each step", grouped(std::uint64_t(count))),
        .margin = 0,
        .pairs_alone = true};
    ShapePool of_a({a}, 47, hull_points), of_b({b}, 53, hull_points);
    ContactSteps fresh{.mode = "fresh", .steps = std::vector<Poses>(4)};
    for (int i = 0; i < count; ++i) {
        const auto k = static_cast<std::size_t>(i);
        ShapeDice dice(59, k);
        for (Poses& poses : fresh.steps) {
            Isometry3d at_a(dice.rotation());
            at_a.translation() = 2 * Vector3d(i % 10, i / 10 % 10, i / 100);
            poses.push_back(at_a), poses.push_back(touching(of_a.model(k), at_a, of_b.model(7 * k), dice));
        }
        const Poses& last = fresh.steps.back();
        scene.bodies.push_back(mover(of_a.geometry(k), last[2 * k]));
        scene.bodies.push_back(mover(of_b.geometry(7 * k), last[2 * k + 1]));
    }
    fresh.first = fresh.steps.back();
    scene.modes.push_back(std::move(fresh));
    return scene;
}

} // namespace

std::vector<ContactEntry> shape_scenes(int bodies)
{
    std::vector<ContactEntry> all;
    const auto add = [&](std::string name, int count, auto make) {
        all.push_back({fmt::format("{}-{}", name, count), [=, n = bodies ? bodies : count] { return make(n); }});
    };
    for (const int count : {1000, 10'000}) add("pile-boxes", count, pile_of_boxes);
    using enum ShapeKind;
    const auto add_heap = [&](const char* of, const char* what, const Kinds& kinds) {
        add(fmt::format("pile-{}", of), 1000, [=](int n) { return heap(of, what, kinds, n); });
    };
    add_heap("mixed", "boxes, spheres and capsules", {box, sphere, capsule});
    add_heap("spheres", "spheres", {sphere}), add_heap("capsules", "capsules", {capsule});
    add_heap("hulls", "convex hulls of 8 to 60 points", {hull});
    add_heap("round", "cylinders, cones and ellipsoids", {cylinder, cone, ellipsoid});
    add("terrain-shapes", 1000, [](int n) { return on_ground(false, n); });
    add("mesh-shapes", 1000, [](int n) { return on_ground(true, n); });
    for (const auto& [a, b] : std::initializer_list<std::pair<ShapeKind, ShapeKind>>{{sphere, sphere},
                                                                                     {capsule, capsule},
                                                                                     {box, sphere},
                                                                                     {box, capsule},
                                                                                     {box, box},
                                                                                     {hull, hull},
                                                                                     {box, hull},
                                                                                     {cylinder, cylinder},
                                                                                     {cone, cone},
                                                                                     {ellipsoid, ellipsoid},
                                                                                     {box, cylinder}}) {
        all.push_back({pair_name(a, b), [=, n = bodies ? bodies : 500] { return single_pairs(a, b, n); }});
    }
    return all;
}

} // namespace oncollide::tools
