// Scene files that save_scene writes.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/generators.hpp>

#include "scenes/files/scene_file_fixture.hpp"

namespace oncollide::scene_file_test {
namespace {

Scene made_in_code()
{
    Scene scene;
    scene.name = "quotes \" and \\ and \xc3\xa9";
    scene.frames = 77;
    Mesh soup = make_soup_mesh(40, 0.7, 3, 5);
    soup.vertices[0] = {-0.0, 1.0 / 3, 5e-324};
    const GeometryId mesh = scene.add("soup", make_mesh("soup", soup.vertices, soup.triangles));
    scene.add("sphere", Sphere{0.1});
    scene.add("box", Box{{0.1, 1 / 3.0, 2e-7}});
    scene.add("capsule", Capsule{0.3, 0});
    scene.add("ellipsoid", Ellipsoid{{0.1, 0.2, 0.3}});
    scene.add("cone", Cone{0.3, 0.7});
    scene.add("half-space", HalfSpace{});
    scene.add("cylinder", Cylinder{0.3, 1e9 / 7});
    scene.add("hull", ConvexHull{{{0, 0, 0}, {1, 0.1, 0}, {0, 1 / 7.0, 0}, {0, 0, 1}, {1, 1, 1}}});
    scene.add("map", make_building_map(1, 0.25, 3));
    for (std::uint64_t i = 0; i < 60; ++i) {
        BodyInit body{.name = "body \t" + std::to_string(i), .geometry = GeometryId(i % 7), .motion = Still{}};
        Eigen::Vector4d q(u01(1, i, 0) - 0.5, u01(1, i, 1) - 0.5, u01(1, i, 2) - 0.5, u01(1, i, 3) - 0.5);
        if (i % 6 == 0) q = {0, 0, 0, i % 12 ? -1.0 : 1.0};
        body.pose.linear() = Eigen::Quaterniond(q.normalized()).toRotationMatrix();
        if (i % 5 == 0) body.pose.linear()(0, 1) += 1e-9; // a rotation that no quaternion represents exactly
        body.pose.translation() = Vector3d(u01(2, i, 0) / 3, -0.0, 1e6 * u01(2, i, 1));
        const Aabb walls{{-1, -1.1, 0}, {2, 2 / 3.0, 1e6}};
        const Eigen::Quaterniond unit(Eigen::Vector4d(q.normalized()));
        if (i % 7 == 1) body.motion = Keyed{{{0.1, {1, 2, 1 / 3.0}, unit}, {9.7, {0, -0.0, 1}, unit.conjugate()}}};
        if (i % 7 == 2) body.motion = Drift{{0.1, 1 / 9.0, -0.3}, {0, 0.1, 1 / 7.0}, walls};
        if (i % 7 == 3) body.motion = Drift{{0.1, 0, -0.3}, Vector3d::Zero(), {}};
        if (i % 7 == 4) body.motion = Jitter{1 / 3.0, 0xffffffffffffffffu, i, walls};
        if (i % 7 == 5) body.motion = Jitter{0.3, 5, i, {}};
        if (i % 7 == 6) body.is_static = true;
        body.layer = i % 4 == 0 ? 0x80000000u : 1u;
        body.mask = i % 3 == 0 ? 0u : 0xffffffffu;
        body.group = static_cast<std::uint32_t>(i % 4);
        if (i % 10 == 9) body.name.clear();
        scene.add_body(std::move(body));
    }
    scene.exclude(SceneBodyId{9}, SceneBodyId{3});
    scene.exclude(SceneBodyId{19}, SceneBodyId{29});
    scene.exclude(SceneBodyId{0}, SceneBodyId{1});
    scene.set_geometry(SceneBodyId{0}, mesh);
    return scene;
}

TEST_F(SceneFile, GivesBackASceneMadeInCodeBitForBit)
{
    Scene scene = made_in_code();
    save_scene(scene, folder_.path() / "made.json");
    Scene read = test::load_with_samples(folder_.path() / "made.json");
    test::expect_same_scene(scene, read);
    EXPECT_TRUE(read.warnings.empty());
}

TEST_F(SceneFile, WritesAQuaternionWhereItGivesTheMatrixBackAndElseTheMatrix)
{
    save_scene(made_in_code(), folder_.path() / "made.json");
    int quaternions = 0, matrices = 0;
    const auto json = nlohmann::json::parse(content_of("made.json"));
    for (const auto& body : json["bodies"])
        if (body.contains("rotation")) ++(body["rotation"].size() == 4 ? quaternions : matrices);
    EXPECT_GT(quaternions, 0);
    EXPECT_GT(matrices, 0);
}

TEST_F(SceneFile, SavesTheStartNotTheCurrentPoses)
{
    Scene scene = made_in_code(), moved = made_in_code();
    Mover().move(moved, 33);
    save_scene(scene, folder_.path() / "a.json");
    save_scene(moved, folder_.path() / "a2.json");
    Scene again = test::load_with_samples(folder_.path() / "a2.json");
    test::expect_same_scene(scene, again);
}

TEST_F(SceneFile, NamesMeshFilesRelativeToWhereItIsWritten)
{
    std::filesystem::create_directories(folder_.path() / "deep" / "er");
    folder_.write("tri.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    Scene scene = load_geometry(R"({"mesh": {"file": "tri.obj", "fit_diagonal": 3}})");
    save_scene(scene, folder_.path() / "deep" / "er" / "moved.json");
    EXPECT_NE(content_of("deep/er/moved.json").find("\"../../tri.obj\""), std::string::npos)
        << content_of("deep/er/moved.json");
    Scene read = test::load_with_samples(folder_.path() / "deep" / "er" / "moved.json");
    test::expect_same_scene(scene, read);

    // The pair of files may move together.
    std::filesystem::rename(folder_.path() / "deep", folder_.path() / "depth");
    Scene moved = test::load_with_samples(folder_.path() / "depth" / "er" / "moved.json");
    test::expect_same_scene(scene, moved);
}

TEST_F(SceneFile, LeavesNothingBehindWhenItCannotWrite)
{
    const Scene scene = made_in_code();
    expect_error(
        ErrorKind::cannot_write, [&] { save_scene(scene, folder_.path() / "none" / "a.json"); }, "a");
    expect_error(
        ErrorKind::cannot_write, [&] { save_scene(scene, folder_.path()); }, "folder");
    expect_error(
        ErrorKind::cannot_write, [&] { save_scene(scene, "/dev/full/a.json"); }, "a");
    EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
    Scene bad = made_in_code();
    bad.name = "\xff";
    expect_error(
        ErrorKind::cannot_write, [&] { save_scene(bad, folder_.path() / "a.json"); }, "UTF-8");
    EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(SceneFile, ReplacesAnOldFileInOneStep)
{
    folder_.write("old.json", "old");
    const Scene scene = load_body(ball);
    save_scene(scene, folder_.path() / "old.json");
    EXPECT_EQ(test::load_with_samples(folder_.path() / "old.json").size(), 1u);
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
        EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << entry.path();
}

} // namespace
} // namespace oncollide::scene_file_test
