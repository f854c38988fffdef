// Solid mode: bodies inside bodies, compared with solid angles and brute force over all triangles.
#include <cmath>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/model/mesh_topology.hpp>
#include <oncollide/scenes/motion.hpp>

#include "narrowphase/mesh_parts.hpp"
#include "random_pose.hpp"

namespace oncollide {
namespace {

Settings solid(ExactLevel exact, BoundingVolume spheres = BoundingVolume::automatic)
{
    Settings settings;
    settings.exact = exact, settings.bounding_volume = spheres, settings.mode = Mode::solid;
    return settings;
}

PairResult answer(const Scene& scene, const Settings& settings)
{
    Pipeline pipeline(scene, settings);
    const FrameView frame = pipeline.step(scene);
    return frame.pairs.empty() ? PairResult{{Verdict::separate, ContactKind::unknown, 0}, StageId::bounds, {}, {}}
                               : frame.pairs[0];
}

enum class Truth { apart, enclosed, meeting, unsure };

const Mesh& mesh_of(const Scene& scene, std::size_t body)
{
    return std::get<Mesh>(scene.geometries[index(scene.geometry[body])].data);
}

/// Whether `outer` winds around a corner of some part of `inner`. Their surfaces do not meet.
Truth inside(const Scene& scene, std::size_t outer, std::size_t inner)
{
    const Mesh &around = mesh_of(scene, outer), &mesh = mesh_of(scene, inner);
    const Eigen::Isometry3d into = scene.poses[outer].inverse(Eigen::Isometry) * scene.poses[inner];
    const std::vector<std::uint32_t> parts = parts_of(mesh);
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (parts[i] != next) continue;
        ++next;
        const double winding = winding_number(around, into * mesh.vertices[mesh.triangles[i][0]]);
        if (std::abs(winding - std::round(winding)) > 1e-3) return Truth::unsure;
        if (std::round(winding) != 0) return Truth::enclosed;
    }
    return Truth::apart;
}

Truth truth_of(const Scene& scene)
{
    const RelativePose b_to_a(scene.poses[0], scene.poses[1]);
    const Mesh &a = mesh_of(scene, 0), &b = mesh_of(scene, 1);
    std::vector<TrianglePoints> in_a;
    for (const Triangle& t : b.triangles)
        in_a.push_back({b_to_a(b.vertices[t[0]]), b_to_a(b.vertices[t[1]]), b_to_a(b.vertices[t[2]])});
    for (const Triangle& t : a.triangles)
        for (const TrianglePoints& q : in_a)
            if (triangles_meet({a.vertices[t[0]], a.vertices[t[1]], a.vertices[t[2]]}, q)) return Truth::meeting;
    const Truth first = inside(scene, 0, 1);
    return first == Truth::apart ? inside(scene, 1, 0) : first;
}

/// Nested, disjoint and crossing; hollow and of several parts; some with reversed orientation; in either order.
TEST(SolidMode, EqualsTheTruthOnAThousandRandomPairs)
{
    const Mesh outers[] = {make_sphere_mesh(1, 160),
                           make_torus_mesh(1, 0.45, 240),
                           make_box_mesh({0.9, 0.7, 1}),
                           flipped(make_sphere_mesh(1, 120)),
                           make_torus_knot_mesh(2, 3, 1, 0.5, 0.3, 400),
                           joined({make_sphere_mesh(1, 160), flipped(make_sphere_mesh(0.6, 100))}),
                           joined({make_sphere_mesh(0.7, 100), moved(make_box_mesh({0.5, 0.5, 0.5}), {1.1, 0, 0})})};
    const Mesh inners[] = {make_sphere_mesh(1, 60), make_box_mesh({0.4, 0.9, 0.6}), make_torus_mesh(1, 0.3, 120),
                           joined({make_box_mesh({0.1, 0.1, 0.1}), moved(make_box_mesh({0.1, 0.1, 0.1}), {3, 1, 0})})};
    int count[4] = {}, judged = 0;
    for (std::uint64_t seed = 0; judged < 1000; ++seed) {
        ASSERT_LT(seed, 4000u);
        const Mesh& outer = outers[seed % std::size(outers)];
        const Mesh inner =
            transformed("inner", inners[seed % std::size(inners)], 0.03 + 0.4 * u01(seed, 4, 0), {0, 0, 0});
        const bool swapped = u01(seed, 4, 1) < 0.5;
        Scene scene;
        scene.add_body({.name = "a", .geometry = scene.add("a", swapped ? inner : outer)});
        scene.add_body({.name = "b", .geometry = scene.add("b", swapped ? outer : inner)});
        scene.set_pose(SceneBodyId{0}, random_pose(seed, 5)),
            scene.set_pose(SceneBodyId{1}, scene.poses[0] * random_pose(seed + 7000, 0.9));
        const Truth truth = truth_of(scene);
        ++count[int(truth)];
        if (truth == Truth::unsure || truth == Truth::meeting) continue;
        ++judged;
        const bool enclosed = truth == Truth::enclosed;
        for (const Settings& settings : {solid(ExactLevel::predicates), solid(ExactLevel::fcl)}) {
            const PairResult result = answer(scene, settings);
            EXPECT_EQ(result.verdict, enclosed ? Verdict::colliding : Verdict::separate) << seed;
            EXPECT_EQ(result.kind, enclosed ? ContactKind::enclosed : ContactKind::unknown) << seed;
        }
        for (const BoundingVolume spheres : {BoundingVolume::sphere, BoundingVolume::obb}) {
            const PairResult result = answer(scene, solid(ExactLevel::off, spheres));
            if (result.verdict == Verdict::within) continue; // spheres cannot decide, and report it
            EXPECT_EQ(result.verdict, enclosed ? Verdict::colliding : Verdict::separate) << seed;
        }
    }
    EXPECT_GE(count[int(Truth::enclosed)], 300);
    EXPECT_GE(count[int(Truth::apart)], 300);
    EXPECT_LE(count[int(Truth::unsure)], 5);
}

/// A shell inside another shell that is slightly larger.
TEST(SolidMode, SeesConcentricShellsHoweverNear)
{
    for (const double gap : {1e-1, 1e-4, 1e-8, 1e-12, 1e-15})
        for (const bool swapped : {false, true}) {
            Scene scene;
            const Mesh box = make_box_mesh({1, 1, 1}), larger = make_box_mesh(Eigen::Vector3d::Constant(1 + gap));
            scene.add_body({.name = "a", .geometry = scene.add("a", swapped ? box : larger)});
            scene.add_body({.name = "b", .geometry = scene.add("b", swapped ? larger : box)});
            EXPECT_EQ(answer(scene, solid(ExactLevel::predicates)).kind, ContactKind::enclosed) << gap;
            EXPECT_EQ(answer(scene,
                             [] {
                                 Settings s = solid(ExactLevel::predicates);
                                 s.clearance = 0.5;
                                 return s;
                             }())
                          .kind,
                      ContactKind::enclosed)
                << "not only near";
        }
    // In a cavity no body is enclosed, at any distance from the wall.
    for (const double gap : {1e-4, 1e-12}) {
        Scene scene;
        const Mesh hollow = joined({make_box_mesh({2, 2, 2}), flipped(make_box_mesh({1, 1, 1}))});
        scene.add_body({.name = "a", .geometry = scene.add("a", hollow)});
        scene.add_body({.name = "b", .geometry = scene.add("b", make_box_mesh(Eigen::Vector3d::Constant(1 - gap)))});
        EXPECT_EQ(answer(scene, solid(ExactLevel::predicates)).verdict, Verdict::separate) << gap;
    }
}

TEST(SolidMode, SeesShapesAndMapsInsideMeshes)
{
    Scene scene;
    scene.add_body({.name = "ball", .geometry = scene.add("ball", make_sphere_mesh(60, 500))});
    scene.add_body({.name = "map", .geometry = scene.add("map", make_building_map(1, 0.5, 3)), .is_static = true});
    scene.add_body({.name = "shape", .geometry = scene.add("shape", Box{{0.1, 0.1, 0.1}})});
    scene.set_position(SceneBodyId{2}, {0, 0, -40});
    for (const ExactLevel exact : {ExactLevel::off, ExactLevel::predicates, ExactLevel::fcl}) {
        Pipeline pipeline(scene, solid(exact));
        const FrameView frame = pipeline.step(scene);
        ASSERT_GE(frame.pairs.size(), 2u);
        EXPECT_EQ(frame.pairs[0].kind, ContactKind::enclosed) << "the map";
        EXPECT_EQ(frame.pairs[1].kind, ContactKind::enclosed) << "the shape";
    }
}

/// The centre of a hull's box need not be in the hull.
TEST(SolidMode, SeesACornerInsideALargerOne)
{
    const auto corner = [](double low, double high) {
        return std::vector<Eigen::Vector3d>{{low, low, low}, {high, low, low}, {low, high, low}, {low, low, high}};
    };
    Scene scene;
    scene.add_body({.name = "mesh",
                    .geometry = scene.add(
                        "mesh", make_mesh("mesh", corner(-0.1, 1.2), {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}))});
    scene.add_body({.name = "hull", .geometry = scene.add("hull", ConvexHull{corner(0, 0.8)})});
    for (const ExactLevel exact : {ExactLevel::predicates, ExactLevel::fcl})
        EXPECT_EQ(answer(scene, solid(exact)).kind, ContactKind::enclosed);
}

TEST(SolidMode, NeedsNoRoomForTrees)
{
    Scene scene;
    scene.add_body({.name = "ball", .geometry = scene.add("ball", make_sphere_mesh(2, 500))});
    scene.add_body({.name = "box", .geometry = scene.add("box", make_box_mesh({0.1, 0.1, 0.1}))});
    for (const ExactLevel exact : {ExactLevel::off, ExactLevel::predicates, ExactLevel::fcl}) {
        Settings settings = solid(exact);
        settings.memory_budget = 1;
        const PairResult result = answer(scene, settings);
        if (exact != ExactLevel::off) { // the budget does not suffice to separate the surfaces
            EXPECT_EQ(result.verdict, Verdict::undecided);
        }
        EXPECT_NE(result.verdict, Verdict::separate);
    }
}

TEST(SolidMode, RefusesOpenMeshesUnlessTheyAreTakenAsSurfaces)
{
    Scene scene;
    scene.add_body({.name = "ground", .geometry = scene.add("ground", make_terrain_mesh(8, 1, 8, 1))});
    scene.add_body({.name = "ball", .geometry = scene.add("ball", make_sphere_mesh(60, 500))});
    Settings settings = solid(ExactLevel::predicates);
    try {
        Pipeline pipeline(scene, settings);
        FAIL() << "accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::bad_data);
        EXPECT_NE(std::string(error.what()).find("ground: the mesh is not closed"), std::string::npos) << error.what();
    }
    settings.open_as_surface = true;
    EXPECT_EQ(answer(scene, settings).kind, ContactKind::enclosed) << "a surface in a solid";
    Settings surface;
    surface.open_as_surface = true;
    EXPECT_THROW(check(surface), Error);
}

TEST(SolidMode, GivesOneHashForAnyNumberOfThreads)
{
    Scene scene;
    const GeometryId ball = scene.add("ball", make_sphere_mesh(1, 300)),
                     box = scene.add("box", make_box_mesh({0.1, 0.1, 0.1}));
    for (std::uint64_t i = 0; i < 80; ++i)
        scene.add_body({.name = std::to_string(i), .geometry = i % 4 ? box : ball, .pose = random_pose(i, 2)});
    std::uint64_t expected = 0;
    for (const int threads : {1, 3}) {
        Settings settings = solid(ExactLevel::predicates);
        settings.threads = threads, settings.contact_kinds = true;
        Pipeline pipeline(scene, settings);
        int enclosed = 0;
        for (const PairResult& pair : pipeline.step(scene).pairs) enclosed += pair.kind == ContactKind::enclosed;
        EXPECT_GT(enclosed, 5);
        if (threads == 1) expected = pipeline.hash();
        EXPECT_EQ(pipeline.hash(), expected);
    }
}

} // namespace
} // namespace oncollide
