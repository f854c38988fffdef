// World::models().set_vertices(): the call, its effects and its errors.
#include <gtest/gtest.h>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "allocations.hpp"
#include "deforming_mesh.hpp"
#include "random_pose.hpp"
#include "refusal.hpp"

namespace oncollide::set_vertices_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// A sheet, and a body that is apart from it until a part of the sheet reaches it.
struct Sheet {
    World world;
    Mesh mesh = make_terrain_mesh(2, 0.01, 40, 1);
    ModelId sheet, ball;
    BodyId a, b;

    explicit Sheet(const Settings& settings = {}) : world(settings)
    {
        sheet = world.models().add(mesh), ball = world.models().add(make_sphere_mesh(0.1, 200));
        a = world.bodies().add({.model = sheet});
        b = world.bodies().add({.model = ball, .pose = Isometry3d(Eigen::Translation3d(0.3, 0.3, 0.5))});
    }
    void lift(double height)
    {
        std::vector<Vector3d> moved = mesh.vertices;
        for (Vector3d& p : moved) p.z() += height * p.head<2>().norm();
        world.models().set_vertices(sheet, moved);
    }
    Verdict verdict()
    {
        const FrameView view = world.step();
        return view.pairs.empty() ? Verdict::separate : view.pairs[0].verdict;
    }
};

TEST(SetVertices, IsSeenByBodiesAtRestAndAsleep)
{
    Sheet s;
    EXPECT_EQ(s.verdict(), Verdict::separate);
    s.world.bodies().sleep(s.a), s.world.bodies().sleep(s.b);
    EXPECT_EQ(s.verdict(), Verdict::separate);
    s.lift(1.2);
    EXPECT_EQ(s.world.pairs().decide(s.a, s.b).verdict, Verdict::colliding) << "before the step, too";
    EXPECT_EQ(s.verdict(), Verdict::colliding);
    EXPECT_EQ(s.verdict(), Verdict::colliding);
    s.lift(0.1);
    EXPECT_EQ(s.verdict(), Verdict::separate);
    s.world.bodies().set_static(s.a, true);
    EXPECT_EQ(s.verdict(), Verdict::separate);
    s.lift(1.2);
    EXPECT_EQ(s.verdict(), Verdict::colliding);
}

TEST(SetVertices, KeepsAGapThatIsLargerThanTheMotionOfTheVertices)
{
    Sheet s;
    s.lift(0.8); // their boxes overlap
    EXPECT_EQ(s.verdict(), Verdict::separate);
    s.lift(0.80001);
    const FrameView kept = s.world.step();
    ASSERT_EQ(kept.pairs.size(), 1u);
    EXPECT_EQ(kept.trees.by_gap, 1u);
    EXPECT_LE(kept.pairs[0].bound, s.world.pairs().distance(s.a, s.b).upper);
    s.lift(0.80001);
    EXPECT_EQ(s.world.step().trees.kept, 1u) << "no vertex moved";
}

TEST(SetVertices, AllocatesNothingOnceWarm)
{
    Sheet s;
    const BodyId turned = s.world.bodies().add({.model = s.sheet, .pose = random_pose(3, 0.5)});
    std::vector<std::vector<Vector3d>> shapes;
    for (int k = 0; k < 20; ++k) shapes.push_back(deformed(s.mesh.vertices, DeformingWay::wave, 0.05 * k));
    const auto play = [&] {
        for (const auto& shape : shapes) {
            s.world.models().set_vertices(s.sheet, shape);
            s.world.models().set_vertices(s.sheet, 100, std::span(shape).subspan(200, 50));
            s.world.step();
        }
    };
    play(), play();
    const std::size_t before = allocations;
    play();
    EXPECT_EQ(allocations, before);
    EXPECT_TRUE(s.world.bodies().contains(turned));
}

TEST(SetVertices, GivesAGeometryThatOtherWorldsAccept)
{
    Sheet s;
    s.lift(0.5);
    const Geometry& now = s.world.models().geometry(s.sheet);
    const Mesh& mesh = std::get<Mesh>(now.data);
    EXPECT_NO_THROW(check_mesh("sheet", mesh));
    EXPECT_EQ(mesh.triangles, s.mesh.triangles);
    EXPECT_EQ(s.mesh.vertices[5], make_terrain_mesh(2, 0.01, 40, 1).vertices[5]) << "the caller's mesh stays";
    EXPECT_FALSE(s.world.models().closed(s.sheet));
}

/// A box whose lid opens: closedness follows the vertices, which are at equal positions only while it is shut.
TEST(SetVertices, OpensAndClosesAMesh)
{
    const Mesh box = make_box_mesh({1, 1, 1}, 1); // faces share no vertices
    Settings settings{.mode = Mode::solid, .open_as_surface = true};
    World world(settings);
    const ModelId model = world.models().add(box), small = world.models().add(Shape(Sphere{0.1}));
    world.bodies().add({.model = model}), world.bodies().add({.model = small});
    std::vector<Vector3d> open = box.vertices;
    for (std::uint32_t v : box.triangles[0]) open[v] *= 1.25;
    for (int round = 0; round < 3; ++round) {
        world.models().set_vertices(model, box.vertices);
        EXPECT_TRUE(world.models().closed(model));
        EXPECT_EQ(world.step().pairs[0].verdict, Verdict::colliding) << "enclosed";
        world.models().set_vertices(model, open);
        EXPECT_FALSE(world.models().closed(model));
        EXPECT_EQ(world.step().pairs[0].verdict, Verdict::separate);
    }
    World solid({.mode = Mode::solid});
    const ModelId closed = solid.models().add(box);
    EXPECT_NO_THROW(solid.models().set_vertices(closed, open)) << "no body uses it";
    EXPECT_THROW(solid.bodies().add({.model = closed}), Error);
    solid.models().set_vertices(closed, box.vertices);
    solid.bodies().add({.model = closed});
    EXPECT_THROW(solid.models().set_vertices(closed, open), Error);
    EXPECT_TRUE(solid.models().closed(closed)) << "nothing has changed";
}

TEST(SetVertices, RefusesWhatIsNoMeshOrHasNoSuchVertices)
{
    Sheet s;
    auto& models = s.world.models();
    const std::uint64_t hash = s.world.step().hash;
    const std::vector<Vector3d> good = s.mesh.vertices;
    const ModelId shape = models.add(Shape(Sphere{1}), "shape");
    says(refusal([&] { models.set_vertices(shape, good); }), "is not a mesh");
    says(refusal([&] { models.set_vertices(ModelId{}, good); }), "null");
    says(refusal([&] { models.set_vertices(s.sheet, std::span(good).first(7)); }),
         "7 positions are given for 1681 vertices; give one for each");
    says(refusal([&] { models.set_vertices(s.sheet, 1680, std::span(good).first(2)); }),
         "2 positions from vertex 1680 are given, but the mesh has 1681");
    says(refusal([&] { models.set_vertices(s.sheet, std::size_t(-1), std::span(good).first(2)); }), "positions from");
    for (const int before : {0, 1}) { // the first call copies the mesh
        if (before) models.set_vertices(s.sheet, good);
        std::vector<Vector3d> bad = good;
        bad[17].y() = std::nan("");
        says(refusal([&] { models.set_vertices(s.sheet, bad); }), "mesh: vertex 17 is not finite");
        says(refusal([&] { models.set_vertices(s.sheet, 10, std::span(bad).subspan(10, 20)); }), "vertex 17 is not");
        bad[17].y() = 2e15;
        says(refusal([&] { models.set_vertices(s.sheet, bad); }), "vertex 17 is too far");
        EXPECT_EQ(std::get<Mesh>(models.geometry(s.sheet).data).vertices, good);
        EXPECT_EQ(s.world.step().hash, hash);
    }
    EXPECT_NO_THROW(models.set_vertices(s.sheet, 1681, {}));
}

} // namespace
} // namespace oncollide::set_vertices_test
