// Shapes, meshes and maps in all pairs, compared with bounds on their distance that share no code with the library.
#include <gtest/gtest.h>

#include <numbers>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "verify/trials/differential.hpp"
#include "verify/trials/sweep_trial.hpp"

namespace oncollide {
namespace {

TEST(Differential, DrawnScenesHaveNoFault)
{
    for (std::uint64_t seed = 1; seed <= 1500; ++seed) {
        const tools::DrawnScene drawn = tools::draw_scene(seed);
        ASSERT_EQ(tools::fault_in(drawn), "") << "seed " << seed << "; 'oncollide-lab fuzz' shrinks it";
    }
}

TEST(Differential, DrawnSweepsHaveNoFault)
{
    const tools::SweepTallies tallies = tools::try_sweeps(1, 4000, 1, [] {});
    EXPECT_EQ(tallies.first.what, "") << "seed " << tallies.first.seed;
    tools::SweepTally all;
    for (const auto& [kinds, tally] : tallies) all += tally;
    EXPECT_EQ(all.sweeps, 4000u);
    EXPECT_EQ(all.contacts + all.at_start + all.clear + all.open, 4000u);
    EXPECT_GT(all.contacts, 1000u);
    EXPECT_GT(all.clear, 1000u);
    EXPECT_LT(all.open, 40u);
    EXPECT_GT(tallies.size(), 60u) << "pairs of kinds";
}

TEST(Differential, WrongSweepsAreFaults)
{
    int missed = 0, early = 0, wide = 0, changed = 0;
    for (std::uint64_t seed = 1; seed <= 300; ++seed) {
        const tools::DrawnSweep drawn = tools::draw_sweep(seed);
        const SweepResult found = tools::sweep_of(drawn);
        if (found.verdict != Verdict::colliding || found.contact_by == 0 || found.contact_by > 0.9) continue;
        const auto judged = [&](auto change) {
            SweepResult wrong = found;
            change(wrong);
            tools::SweepTally tally;
            tools::fault_in(drawn, wrong, found, seed,
                            seed % 2 ? tools::PoseJudge::truth : tools::PoseJudge::exact_tests, tally);
            return tally;
        };
        missed += judged([](SweepResult& r) { r.verdict = Verdict::separate, r.clear_until = 1; }).missed;
        missed += judged([](SweepResult& r) { r.clear_until = r.contact_by + 0.02; }).missed;
        early += judged([](SweepResult& r) { r.contact_by = r.clear_until = 0.5 * r.clear_until; }).early;
        wide += judged([](SweepResult& r) { r.clear_until -= 0.01 * r.clear_until + 0.001; }).wide;
        changed += judged([](SweepResult& r) { r.clear_until = r.contact_by = r.contact_by + 1e-9; }).faults() > 0;
    }
    EXPECT_GT(missed, 40);
    EXPECT_GT(early, 20);
    EXPECT_GT(wide, 20);
    EXPECT_GT(changed, 20);
}

/// Seeds of former faults.
TEST(Differential, FaultsOfOldStayMended)
{
    // Former faults: if the budget was exhausted, a pair on which FCL and the exact tests differed lost its result; and
    // libccd ended the program in a distance query of touching shapes.
    for (const std::uint64_t seed : {271814, 2054478}) EXPECT_EQ(tools::fault_in(tools::draw_scene(seed)), "") << seed;
}

/// The artificial fault is two spheres in solid mode: nothing else remains in the scene.
TEST(Differential, AFaultIsShrunkToWhatItNeeds)
{
    const auto faulty = [](const tools::DrawnScene& drawn) {
        int balls = 0;
        for (std::size_t g = 0; g < drawn.scene.geometries.size(); ++g) {
            const auto* shape = std::get_if<Shape>(&drawn.scene.geometries[g].data);
            balls += shape && std::holds_alternative<Sphere>(*shape);
        }
        return balls >= 2 && drawn.settings.mode == Mode::solid;
    };
    std::uint64_t seed = 1;
    tools::DrawnScene drawn;
    do drawn = tools::draw_scene(seed++);
    while (!faulty(drawn) || drawn.scene.size() < 4);
    drawn.settings.clearance = 0.5, drawn.settings.threads = 3;
    const tools::DrawnScene small = tools::shrunk(drawn, faulty);
    EXPECT_EQ(small.scene.size(), 2u);
    EXPECT_EQ(small.scene.frames, 1);
    EXPECT_EQ(small.settings.clearance, 0);
    EXPECT_EQ(small.settings.threads, 1);
    EXPECT_TRUE(small.scene.start_pose(0).linear().isIdentity(0));
}

struct Body {
    GeometryData geometry;
    Eigen::Isometry3d pose;
};

Body at(GeometryData geometry, double x, double y, double z)
{
    return {std::move(geometry), Eigen::Isometry3d(Eigen::Translation3d(x, y, z))};
}

PairResult result_of(const Settings& settings, const Body& a, const Body& b)
{
    World world(settings);
    for (const Body* body : {&a, &b}) {
        const ModelId model = std::visit([&](const auto& g) { return world.models().add(g); }, body->geometry);
        world.bodies().add({.model = model, .pose = body->pose});
    }
    const FrameView frame = world.step();
    PairResult apart{{Verdict::separate, ContactKind::unknown, 0}, StageId::bounds, {}, {}};
    apart.verdict = Verdict::separate;
    return frame.pairs.empty() ? apart : frame.pairs[0];
}

Shape hull_of_box(const Eigen::Vector3d& half)
{
    ConvexHull hull;
    for (int k = 0; k < 8; ++k)
        hull.points.push_back(half.cwiseProduct(Eigen::Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)));
    return hull;
}

TEST(ConvexSolids, AHullAndAMeshThatFclPartsCollide)
{
    const Body hull = at(hull_of_box({0.75, 0.5, 1.5}), 2.5, -1.5, 1.5),
               mesh = at(make_box_mesh({0.25, 0.75, 0.25}), 3, -1, 3);
    for (const Mode mode : {Mode::surface, Mode::solid}) {
        EXPECT_EQ(result_of({.exact = ExactLevel::predicates, .mode = mode}, hull, mesh).verdict, Verdict::colliding);
        EXPECT_NE(result_of({.exact = ExactLevel::fcl, .mode = mode}, hull, mesh).verdict, Verdict::separate);
    }
}

TEST(ConvexSolids, BoxesWhoseDistanceFclOverstatesAreWithinTheClearance)
{
    const Body a = at(Shape(Box{{0.25, 1.25, 1}}), 0, -4.5, -2), b = at(Shape(Box{{1, 1, 0.75}}), 1.5, -4.5, -4);
    for (const ExactLevel exact : {ExactLevel::predicates, ExactLevel::fcl}) {
        const PairResult result = result_of({.clearance = 2, .exact = exact}, a, b);
        EXPECT_NE(result.verdict, Verdict::separate);
        EXPECT_GE(result.bound, 0.3535);
    }
    EXPECT_NEAR(result_of({.clearance = 2, .exact = ExactLevel::predicates}, a, b).bound, 0.3536, 1e-4);
}

TEST(ConvexSolids, TellHowPolytopesTouch)
{
    const Settings settings{.exact = ExactLevel::predicates, .contact_kinds = true};
    const Shape box = Box{{1, 1, 1}};
    EXPECT_EQ(result_of(settings, at(box, 0, 0, 0), at(box, 2, 0, 0)).kind, ContactKind::touching);
    EXPECT_EQ(result_of(settings, at(box, 0, 0, 0), at(box, 1, 0, 0)).kind, ContactKind::crossing);
    EXPECT_EQ(result_of(settings, at(box, 0, 0, 0), at(Shape(Box{{0.1, 0.1, 0.1}}), 0.5, 0, 0)).kind,
              ContactKind::enclosed);
    EXPECT_EQ(result_of(settings, at(box, 0, 0, 0), at(make_box_mesh({0.1, 0.1, 0.1}), 0.5, 0, 0)).kind,
              ContactKind::enclosed);
}

TEST(ConvexSolids, BallsAreDecidedExactlyAndCylindersButForRounding)
{
    const Settings settings{.exact = ExactLevel::predicates};
    const Shape ball = Sphere{1}, box = Box{{1, 1, 1}};
    EXPECT_EQ(result_of(settings, at(ball, 0, 0, 0), at(box, 2 - 1e-9, 0, 0)).verdict, Verdict::colliding);
    EXPECT_EQ(result_of(settings, at(ball, 0, 0, 0), at(box, 2 + 1e-9, 0, 0)).verdict, Verdict::separate);
    EXPECT_EQ(result_of(settings, at(ball, 0, 0, 0), at(box, 2, 0, 0)).verdict, Verdict::colliding);
    EXPECT_EQ(result_of(settings, at(ball, 0, 0, 0), at(box, std::nextafter(2, 3), 0, 0)).verdict, Verdict::separate);
    EXPECT_EQ(result_of(settings, at(ball, 0, 0, 0), at(Shape(Sphere{0.1}), 0.3, 0, 0)).verdict, Verdict::colliding);
    EXPECT_EQ(result_of(settings, at(ball, 0, 0, 0), at(Shape(Cylinder{0.5, 1}), 1.5 - 1e-12, 0, 0)).verdict,
              Verdict::colliding);
    EXPECT_EQ(result_of(settings, at(ball, 0, 0, 0), at(Shape(Cylinder{0.5, 1}), 1.5 + 1e-12, 0, 0)).verdict,
              Verdict::separate);
}

/// Its prisms have corners at the quarters; some points between two corners are only in the outer prism.
TEST(ConvexSolids, ACylinderIsNotPartedFromAMeshBetweenTheCornersOfItsPrism)
{
    Body box = at(make_box_mesh({1, 1, 1}), 0, 0, 0);
    const Eigen::AngleAxisd between_corners(std::numbers::pi / 512, Eigen::Vector3d::UnitZ());
    box.pose = between_corners * Eigen::Translation3d(2 - 1e-7, 0, 0);
    const Settings settings{.exact = ExactLevel::predicates};
    const PairResult result = result_of(settings, at(Shape(Cylinder{1, 1}), 0, 0, 0), box);
    EXPECT_NE(result.verdict, Verdict::separate);
    EXPECT_LT(result.bound, 1e-4);
    box.pose = between_corners * Eigen::Translation3d(2 + 1e-4, 0, 0);
    EXPECT_EQ(result_of(settings, at(Shape(Cylinder{1, 1}), 0, 0, 0), box).verdict, Verdict::separate);
}

/// The parts of such a large mesh are not precomputed: the shape is searched for its triangles.
TEST(Shapes, HoldALooseCrumbOfALargeMesh)
{
    Mesh mesh = make_terrain_mesh(10, 0.5, 300, 1);
    const Eigen::Vector3d crumb(1, -2, 3);
    const Mesh cube = make_box_mesh({0.05, 0.05, 0.05});
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Eigen::Vector3d& v : cube.vertices) mesh.vertices.push_back(v + crumb);
    for (const Triangle& t : cube.triangles) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    ASSERT_GT(mesh.triangles.size(), 1u << 17);
    World world({.exact = ExactLevel::predicates});
    const ModelId ground = world.models().add(make_mesh("ground", mesh.vertices, mesh.triangles));
    Eigen::Isometry3d turn(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
    world.bodies().add({.model = ground, .pose = turn});
    ConvexHull octahedron;
    for (int axis = 0; axis < 3; ++axis)
        for (const double end : {-0.3, 0.3}) octahedron.points.push_back(end * Eigen::Vector3d::Unit(axis));
    for (const Shape& shape : {Shape(Box{{0.2, 0.2, 0.2}}), Shape(octahedron), Shape(Sphere{0.3})})
        for (const bool rotated : {false, true}) {
            const ModelId model = world.models().add(shape);
            const auto verdict = [&](const Eigen::Vector3d& off) {
                Eigen::Isometry3d pose =
                    rotated ? Eigen::Isometry3d(Eigen::AngleAxisd(1, Eigen::Vector3d(0, 1, 1).normalized())) : turn;
                pose.translation() = turn * Eigen::Vector3d(crumb + off);
                const BodyId body = world.bodies().add({.model = model, .pose = pose});
                Verdict found = Verdict::separate;
                for (const PairResult& r : world.step().pairs) found = r.verdict;
                world.bodies().remove(body);
                return found;
            };
            EXPECT_EQ(verdict({0, 0, 0}), Verdict::colliding);
            EXPECT_EQ(verdict({0.05, 0.03, 0.02}), Verdict::colliding);
            EXPECT_EQ(verdict({0.4, 0.4, 0}), Verdict::separate);
            EXPECT_EQ(verdict({0.26, 0.26, 0.26}), Verdict::separate) << "in the octahedron's box, not in it";
            EXPECT_EQ(verdict({0, 0, -1.5}), Verdict::separate) << "nothing there";
        }
}

} // namespace
} // namespace oncollide
