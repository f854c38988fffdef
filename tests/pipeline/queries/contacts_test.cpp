// Contacts of bodies of every kind, part by part, compared with distances of convex sets that share no code with the
// library.
#include <map>

#include <gtest/gtest.h>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "truth/convex_truth.hpp"
#include "verify/cases/drawn_scene.hpp"

namespace oncollide {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double tie = 1e-10; ///< for bodies of a few metres

/// The parts in the order of convex_sets().
std::vector<BodyPart> parts_of(const GeometryData& geometry)
{
    std::vector<BodyPart> parts;
    if (const auto* mesh = std::get_if<Mesh>(&geometry)) {
        for (std::uint32_t t = 0; t < mesh->triangles.size(); ++t) parts.emplace_back(t);
    } else if (const auto* terrain = std::get_if<Terrain>(&geometry)) {
        for (std::uint32_t y = 0; y < terrain->cells_y(); ++y)
            for (std::uint32_t x = 0; x < terrain->cells_x(); ++x)
                for (std::uint32_t half = 0; half < 2; ++half)
                    if (terrain->has_cell(x, y)) parts.emplace_back(2 * (y * terrain->cells_x() + x) + half);
    } else if (const auto* map = std::get_if<OccupancyMap>(&geometry)) {
        map->each_cell(map->bounds(), [&](const MapCell& cell) { return parts.emplace_back(cell), true; });
    } else {
        parts.emplace_back();
    }
    return parts;
}

tools::ConvexSet point(const Vector3d& p)
{
    return [p](const tools::ExtendedVector&) -> tools::ExtendedVector { return p.cast<long double>(); };
}

Aabb box_of(const tools::ConvexSet& set)
{
    Aabb box;
    for (int i = 0; i < 3; ++i) {
        box.min[i] = double(set(-tools::ExtendedVector::Unit(i))[i]) - tie;
        box.max[i] = double(set(tools::ExtendedVector::Unit(i))[i]) + tie;
    }
    return box;
}

std::vector<Aabb> boxes_of(const std::vector<tools::ConvexSet>& sets)
{
    std::vector<Aabb> boxes;
    for (const tools::ConvexSet& set : sets) boxes.push_back(box_of(set));
    return boxes;
}

/// Compares the contacts of two bodies with every pair of parts. Returns how many meet.
std::size_t compare(const World& world, BodyId a, BodyId b, const GeometryData& of_a, const GeometryData& of_b,
                    const Isometry3d& pose_a, const Isometry3d& pose_b, const std::string& where)
{
    const std::vector<tools::ConvexSet> sets_a = tools::convex_sets(of_a, pose_a),
                                        sets_b = tools::convex_sets(of_b, pose_b);
    const std::vector<Aabb> boxes_a = boxes_of(sets_a), boxes_b = boxes_of(sets_b);
    const std::vector<BodyPart> parts_a = parts_of(of_a), parts_b = parts_of(of_b);
    EXPECT_EQ(sets_a.size(), parts_a.size()) << where;
    EXPECT_EQ(sets_b.size(), parts_b.size()) << where;
    std::map<std::pair<BodyPart, BodyPart>, Contact> found;
    const std::vector<Contact> contacts = world.pairs().contacts(a, b);
    for (const Contact& c : contacts) EXPECT_TRUE(found.emplace(std::pair(c.a, c.b), c).second) << where << ", twice";
    EXPECT_TRUE(std::ranges::is_sorted(contacts, {}, [](const Contact& c) { return std::pair(c.a, c.b); })) << where;
    std::size_t meet = 0;
    for (std::size_t i = 0; i < parts_a.size(); ++i)
        for (std::size_t k = 0; k < parts_b.size(); ++k) {
            const auto at = found.find({parts_a[i], parts_b[k]});
            if (at == found.end() && !boxes_a[i].overlaps(boxes_b[k])) continue;
            const tools::TrueDistance truth = tools::convex_distance(sets_a[i], sets_b[k]);
            if (at == found.end()) {
                EXPECT_GT(truth.upper, 0) << where << ", lost: " << i << ", " << k;
                continue;
            }
            ++meet;
            const Contact& c = at->second;
            EXPECT_LE(truth.lower, tie) << where << ", invented: " << i << ", " << k;
            for (const Vector3d& end : c.ends) {
                EXPECT_LE(tools::convex_distance(point(end), sets_a[i]).lower, 1e-7) << where << ", " << i;
                EXPECT_LE(tools::convex_distance(point(end), sets_b[k]).lower, 1e-7) << where << ", " << k;
            }
            for (const Vector3d& normal : {c.normal_a, c.normal_b})
                EXPECT_TRUE(normal.isZero(0) || std::abs(normal.norm() - 1) < 1e-9) << where;
        }
    EXPECT_EQ(meet, found.size()) << where << ": parts that do not exist";
    return meet;
}

TEST(Contacts, OfAllKindsAreThosePartsThatMeet)
{
    std::map<std::pair<std::size_t, std::size_t>, std::size_t> of_kinds;
    for (std::uint64_t seed = 1; seed <= 1200; ++seed) {
        const tools::DrawnScene drawn = tools::draw_scene(seed);
        const Scene& scene = drawn.scene;
        World world;
        std::vector<BodyId> bodies;
        for (std::size_t i = 0; i < scene.size(); ++i) {
            const ModelId model = std::visit([&](const auto& g) { return world.models().add(g); },
                                             scene.geometries[index(scene.geometry[i])].data);
            bodies.push_back(world.bodies().add({.model = model, .pose = scene.start_pose(i)}));
        }
        for (std::size_t i = 0; i < scene.size(); ++i)
            for (std::size_t k = 0; k < scene.size(); ++k) {
                if (i == k) continue;
                const GeometryData &a = scene.geometries[index(scene.geometry[i])].data,
                                   &b = scene.geometries[index(scene.geometry[k])].data;
                if (parts_of(a).size() * parts_of(b).size() > 200000) continue;
                of_kinds[{a.index(), b.index()}] += compare(
                    world, bodies[i], bodies[k], a, b, scene.start_pose(i), scene.start_pose(k),
                    "seed " + std::to_string(seed) + ", bodies " + std::to_string(i) + ", " + std::to_string(k));
                if (HasFailure()) return;
            }
    }
    for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b) EXPECT_GT((of_kinds[{a, b}]), 10) << a << " against " << b;
}

Isometry3d at(double x, double y, double z)
{
    return Isometry3d(Eigen::Translation3d(x, y, z));
}

TEST(Contacts, OfSolidsSayWhichWayIsOut)
{
    World world;
    const BodyId ball = world.bodies().add({.model = world.models().add(Shape(Sphere{1}))});
    const struct {
        Shape shape;
        Isometry3d pose;
        Vector3d normal;
    } others[] = {
        {Box{{5, 5, 1}}, at(0, 0, -1.9), {0, 0, 1}},   {Capsule{0.5, 2}, at(1.4, 0, 0), {-1, 0, 0}},
        {Cylinder{0.5, 2}, at(0, 1.4, 0), {0, -1, 0}}, {Cylinder{3, 1}, at(0, 0, 1.4), {0, 0, -1}},
        {Cone{3, 1}, at(0, 0, 1.4), {0, 0, -1}},       {Ellipsoid{{1, 2, 3}}, at(-1.95, 0, 0), {1, 0, 0}},
        {HalfSpace{}, at(0, 0, -0.5), {0, 0, 1}},
    };
    for (const auto& other : others) {
        const BodyId body = world.bodies().add({.model = world.models().add(other.shape), .pose = other.pose});
        const std::vector<Contact> contacts = world.pairs().contacts(ball, body),
                                   back = world.pairs().contacts(body, ball);
        ASSERT_EQ(contacts.size(), 1u) << other.shape.index();
        ASSERT_EQ(back.size(), 1u);
        EXPECT_LT((contacts[0].normal_b - other.normal).norm(), 1e-6) << contacts[0].normal_b.transpose();
        EXPECT_LT((back[0].normal_a - other.normal).norm(), 1e-6) << back[0].normal_a.transpose();
        EXPECT_GT(contacts[0].normal_a.dot(-other.normal), 0.5) << "of the ball: " << contacts[0].normal_a.transpose();
    }
}

/// The contacts of a half-space are exactly the parts that touch it.
/// Touching triangles are decided by exact arithmetic, crossing ones in eights.
TEST(Contacts, OfTrianglesHaveTheNormalsOfBothWhetherTheyTouchOrCross)
{
    World world;
    const ModelId box = world.models().add(make_box_mesh({1, 1, 1}));
    const Mesh mesh = make_box_mesh({1, 1, 1});
    Isometry3d quarter = Isometry3d::Identity();
    quarter.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    const auto normal_of = [&](const BodyPart& part, const Isometry3d& pose) -> Vector3d {
        const Triangle& t = mesh.triangles[part.triangle];
        const Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        return pose.linear() * (b - a).cross(c - a).normalized();
    };
    for (const auto& [x, kind] : {std::pair(2.0, ContactKind::touching), {1.75, ContactKind::crossing}}) {
        quarter.translation() = Vector3d(x, 0.25, 0.25);
        const PlacedModel a{.model = box}, b{.model = box, .pose = quarter};
        int of_kind = 0;
        for (const Contact& c : world.pairs().contacts(a, b)) {
            of_kind += c.kind == kind;
            EXPECT_LT((c.normal_a - normal_of(c.a, a.pose)).norm(), 1e-12) << name_of(c.kind);
            EXPECT_LT((c.normal_b - normal_of(c.b, b.pose)).norm(), 1e-12) << name_of(c.kind);
        }
        EXPECT_GT(of_kind, 0) << name_of(kind);
    }
}

TEST(Contacts, OfAHalfSpaceAreAllPartsThatReachIntoIt)
{
    World world;
    const BodyId ground = world.bodies().add({.model = world.models().add(Shape(HalfSpace{}))});
    const Mesh mesh = make_sphere_mesh(1, 2000);
    const ModelId model = world.models().add(mesh);
    for (const double height : {2.0, 0.9, 0.0, -0.5, -3.0}) {
        const BodyId body = world.bodies().add({.model = model, .pose = at(0, 0, height)});
        std::size_t low = 0;
        for (const Triangle& t : mesh.triangles)
            low += std::ranges::any_of(t, [&](std::uint32_t v) { return mesh.vertices[v].z() + height <= 0; });
        const std::vector<Contact> contacts = world.pairs().contacts(body, ground);
        EXPECT_EQ(contacts.size(), low) << height;
        for (const Contact& c : contacts) {
            EXPECT_LE(c.ends[0].z(), 0);
            EXPECT_EQ(c.normal_b, Vector3d::UnitZ());
        }
        world.bodies().remove(body);
    }
}

} // namespace
} // namespace oncollide
