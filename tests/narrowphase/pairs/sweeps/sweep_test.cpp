// When two moving bodies first meet: analytic scenes, and all pairs of kinds against the exact tests of single poses.
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/pipeline/models/model_store.hpp>
#include <oncollide/samples/generators.hpp>

#include "every_kind.hpp"
#include "random_pose.hpp"

namespace oncollide {
namespace sweep_test {
namespace {

using Eigen::AngleAxisd, Eigen::Isometry3d, Eigen::Vector3d;

Isometry3d placed(const Vector3d& position, double angle = 0, const Vector3d& axis = Vector3d::UnitZ())
{
    Isometry3d pose = Isometry3d::Identity();
    if (angle != 0) pose.linear() = AngleAxisd(angle, axis.normalized()).toRotationMatrix();
    pose.translation() = position;
    return pose;
}

class Sweeps : public testing::Test {
protected:
    Model& add(GeometryData data)
    {
        Model& model = store_[store_.add(std::make_shared<const Geometry>(Geometry{{}, std::move(data), {}}))];
        if (model.has_triangles()) store_.obb_tree(model, 0);
        return model;
    }
    SweepResult sweep(Model& a, const RigidMotion& motion_a, Model& b, const RigidMotion& motion_b)
    {
        SweepTask task = settings_;
        task.a = &a, task.b = &b, task.motion_a = &motion_a, task.motion_b = &motion_b;
        return tests_for(a.kind(), b.kind()).advance(worker_, task);
    }
    /// The verdict at one time, without witnesses of earlier decisions.
    Finding decide(Model& a, const RigidMotion& motion_a, Model& b, const RigidMotion& motion_b, double time)
    {
        const Isometry3d pose_a = motion_a.pose(time), pose_b = motion_b.pose(time);
        const PairTask at{0, &a, &b, &pose_a, &pose_b};
        return tests_for(at).decide(other_worker_, at, {.clearance = settings_.clearance}, nullptr);
    }
    /// The first contact is at `time`.
    void expect_contact(const SweepResult& r, double time)
    {
        EXPECT_TRUE(r.verdict == Verdict::colliding || r.kind == ContactKind::near) << name_of(r.verdict);
        EXPECT_LE(r.clear_until, time + 1e-15);
        EXPECT_GE(r.contact_by, time - 1e-15);
        EXPECT_LE(r.contact_by - r.clear_until, settings_.options.time_tolerance);
        EXPECT_LE(r.gap, settings_.options.gap_tolerance * (1 + 1e-3) + settings_.clearance);
    }
    void expect_clear(const SweepResult& r)
    {
        EXPECT_EQ(r.verdict, Verdict::separate) << r.clear_until << " to " << r.contact_by << ", gap " << r.gap;
        EXPECT_EQ(r.clear_until, 1);
        EXPECT_EQ(r.contact_by, std::numeric_limits<double>::infinity());
    }

    SweepTask settings_{};
    PairWorker worker_, other_worker_;

private:
    Settings of_world_;
    ModelStore store_{of_world_, make_cpu_backend()};
};

TEST_F(Sweeps, TwoSpheresMeetWhereTheirCentresAreTheRadiiApart)
{
    Model &a = add(Shape(Sphere{1})), &b = add(Shape(Sphere{0.5}));
    const SweepResult r = sweep(a, placed({0, 0, 0}), b, {placed({-4, 0.9, 0}), placed({4, 0.9, 0})});
    expect_contact(r, (4 - std::sqrt(1.5 * 1.5 - 0.9 * 0.9)) / 8);
    EXPECT_LT((r.normal - Vector3d(-std::sqrt(1.5 * 1.5 - 0.9 * 0.9), 0.9, 0) / 1.5).norm(), 1e-3);
    EXPECT_NEAR(r.contact.ends[0].norm(), 1, 1e-4);
    expect_clear(sweep(a, placed({0, 0, 0}), b, {placed({-4, 1.5 + 1e-9, 0}), placed({4, 1.5 + 1e-9, 0})}));
    settings_.clearance = 0.25;
    expect_contact(sweep(a, placed({0, 0, 0}), b, {placed({-4, 0.9, 0}), placed({4, 0.9, 0})}),
                   (4 - std::sqrt(1.75 * 1.75 - 0.9 * 0.9)) / 8);
}

TEST_F(Sweeps, TwoBoxMeshesMeetWhereTheirFacesDo)
{
    Model &a = add(make_box_mesh({1, 1, 1})), &b = add(make_box_mesh({0.5, 0.5, 0.5}));
    const SweepResult r = sweep(a, placed({0, 0, 0}), b, {placed({5, 0.25, 0}), placed({-3, 0.25, 0})});
    expect_contact(r, 3.5 / 8);
    EXPECT_LT((r.normal - Vector3d(1, 0, 0)).norm(), 1e-6);
    EXPECT_NEAR(r.contact.ends[0].x(), 1, 1e-3);
    // Both move: the same relative motion.
    expect_contact(sweep(a, {placed({0, 0, 0}), placed({7, 3, -2})}, b, {placed({5, 0.25, 0}), placed({4, 3.25, -2})}),
                   3.5 / 8);
}

TEST_F(Sweeps, NearMissesOfABillionthAreTold)
{
    Model &a = add(make_box_mesh({1, 1, 1})), &b = add(make_box_mesh({0.5, 0.5, 0.5}));
    for (const double gap : {1e-9, -1e-9}) {
        const double y = 1.5 + gap;
        const SweepResult r = sweep(a, placed({0, 0, 0}), b, {placed({4, y, 0}), placed({-4, y, 0})});
        if (gap > 0)
            expect_clear(r);
        else
            expect_contact(r, 2.5 / 8);
    }
    Model& ball = add(Shape(Sphere{1}));
    expect_clear(sweep(a, placed({0, 0, 0}), ball, {placed({-4, 2 + 2e-9, 0}), placed({4, 2 + 2e-9, 0})}));
}

TEST_F(Sweeps, AGrazingContactOfOneInstantIsFound)
{
    // A ball touches the apex of a tent of two triangles, and the edge of the tent, only at time 0.5.
    Model& tent = add(make_mesh("tent", {{0, 0, 0}, {-1, -1, -4}, {1, -1, -4}, {0, 1, -4}}, {{0, 1, 2}, {0, 2, 3}}));
    Model& ball = add(Shape(Sphere{1}));
    const SweepResult r = sweep(tent, placed({0, 0, 0}), ball, {placed({-1, 0, 1}), placed({1, 0, 1})});
    expect_contact(r, 0.5);
    EXPECT_EQ(r.contact_by, 0.5);
}

TEST_F(Sweeps, ANeedleIsStoppedByAThinPlate)
{
    Model &plate = add(make_box_mesh({1, 1, 0.5e-6})),
          &needle = add(make_mesh("needle", {{0, 0, 0}, {1e-4, 0, 3}, {-1e-4, 0, 3}}, {{0, 1, 2}}));
    for (const double speed : {1.0, 100.0, 1e6}) {
        const RigidMotion motion(placed({0.1, 0.2, 0.25 * speed}), placed({0.1, 0.2, -0.75 * speed}));
        expect_contact(sweep(plate, placed({0, 0, 0}), needle, motion), 0.25 - 0.5e-6 / speed);
    }
}

TEST_F(Sweeps, ABulletOfOneCentimetreAtAThousandMetresAFrameHitsAMesh)
{
    Model &target = add(make_box_mesh({0.5, 0.5, 0.005})), &bullet = add(Shape(Sphere{0.005})),
          &small = add(make_sphere_mesh(0.005, 32));
    const RigidMotion path(placed({0.1, 0.1, 500}), placed({0.1, 0.1, -500}));
    expect_contact(sweep(target, placed({0, 0, 0}), bullet, path), (500 - 0.01) / 1000);
    expect_contact(sweep(small, path, target, placed({0, 0, 0})), (500 - 0.01) / 1000);
    const RigidMotion beside(placed({0.51, 0.1, 500}), placed({0.51, 0.1, -500}));
    expect_clear(sweep(target, placed({0, 0, 0}), bullet, beside));
}

TEST_F(Sweeps, APropellerPassesBetweenPostsOrTouchesThem)
{
    // Its corner is at most sqrt(1 + 0.1^2) from its axis; it stands still at the middle, and turns by a right angle.
    const double reach = std::sqrt(1.01), corner = std::atan(0.1);
    Model &propeller = add(make_box_mesh({1, 0.1, 0.05})), &post = add(make_box_mesh({0.5, 2, 1}));
    const RigidMotion turn(placed({0, 0, 0}, M_PI / 2), placed({0, 0, 0}));
    for (const double face : {reach + 1e-6, 1.004, 1.001}) {
        const SweepResult r = sweep(propeller, turn, post, placed({face + 0.5, 0, 0})),
                          other = sweep(propeller, turn, post, placed({-face - 0.5, 0, 0}));
        EXPECT_EQ(other.verdict, r.verdict);
        EXPECT_NEAR(other.clear_until, r.clear_until, 1e-4) << "the other blade";
        if (face > reach)
            expect_clear(r);
        else // the corner comes from above: its direction is (1 - t) 90 degrees - atan(0.1)
            expect_contact(r, 1 - (std::acos(face / reach) + corner) / (M_PI / 2));
        Model& solid = add(Shape(Box{{1, 0.1, 0.05}}));
        const SweepResult of_shape = sweep(solid, turn, add(Shape(Box{{0.5, 2, 1}})), placed({face + 0.5, 0, 0}));
        EXPECT_EQ(of_shape.verdict, r.verdict);
        EXPECT_NEAR(of_shape.clear_until, r.clear_until, 1e-4);
    }
}

TEST_F(Sweeps, ContactsAtTheEndsAndRest)
{
    Model &a = add(make_box_mesh({1, 1, 1})), &b = add(make_box_mesh({0.5, 0.5, 0.5}));
    const Isometry3d here = placed({0, 0, 0}), touching = placed({1.5, 0, 0}), away = placed({3.5, 0, 0});
    const SweepResult parts = sweep(a, here, b, {touching, away});
    EXPECT_EQ(parts.verdict, Verdict::colliding);
    EXPECT_EQ(parts.contact_by, 0);
    EXPECT_TRUE(parts.separating);
    EXPECT_FALSE(sweep(a, here, b, {touching, here}).separating);
    EXPECT_FALSE(sweep(a, here, b, touching).separating) << "rest";
    const SweepResult last = sweep(a, here, b, {away, touching});
    expect_contact(last, 1);
    EXPECT_EQ(last.contact_by, 1);
    expect_clear(sweep(a, here, b, {away, placed({1.5 + 1e-9, 0, 0})}));
    expect_clear(sweep(a, here, b, away));
    // Every key of a sequence is reached.
    const RigidMotion::Key keys[] = {{0, away}, {0.25, placed({3.5, 9, 0})}, {0.5, placed({-3.5, 9, 0})}, {1, here}};
    expect_contact(sweep(a, here, b, RigidMotion(keys)),
                   0.5 + 0.5 * (9 - 1.5) / 9); // y falls to 1.5 last: x is then within the box
}

TEST_F(Sweeps, ABodyThatBeginsInsideASolidIsAContactAtOnce)
{
    Model &outer = add(make_sphere_mesh(2, 512)), &inner = add(make_sphere_mesh(0.25, 32));
    const RigidMotion out(placed({0, 0, 0}), placed({4, 0, 0}));
    const SweepResult of_surfaces = sweep(outer, placed({0, 0, 0}), inner, out);
    EXPECT_GT(of_surfaces.clear_until, 0.4);
    EXPECT_EQ(of_surfaces.verdict, Verdict::colliding);
    settings_.solid = true;
    const SweepResult of_solids = sweep(outer, placed({0, 0, 0}), inner, out);
    EXPECT_EQ(of_solids.contact_by, 0);
    EXPECT_EQ(of_solids.kind, ContactKind::enclosed);
}

TEST_F(Sweeps, AFallingBodyMeetsAHalfSpace)
{
    Model &ground = add(Shape(HalfSpace{})), &box = add(make_box_mesh({1, 1, 1}));
    const RigidMotion fall(placed({0, 0, 5}), placed({0, 0, 1}));
    expect_contact(sweep(ground, placed({0, 0, 0}), box, fall), 1);
    expect_contact(sweep(box, {placed({7, 0, 5}), placed({9, 0, 0})}, ground, placed({0, 0, 0})), 4.0 / 5);
    expect_clear(sweep(ground, placed({0, 0, 0}), box, {placed({0, 0, 5}), placed({0, 0, 1 + 1e-9})}));
    // On its corner, after a turn; the lowest point of a box that turns about y by t pi/4 is at -(cos + sin).
    const RigidMotion turn(placed({0, 0, 1.2}), placed({0, 0, 1.2}, M_PI / 4, Vector3d::UnitY()));
    expect_contact(sweep(ground, placed({0, 0, 0}), box, turn),
                   (std::asin(1.2 / std::sqrt(2)) - M_PI / 4) / (M_PI / 4));
    expect_contact(sweep(ground, {placed({0, 0, 0}), placed({0, 0, 2})}, box, placed({0, 0, 2})), 0.5);
}

TEST_F(Sweeps, HalfSpacesThatRotateMeetAtOnce)
{
    Model &a = add(Shape(HalfSpace{})), &b = add(Shape(HalfSpace{}));
    const Isometry3d floor = placed({0, 0, 0}), tilted = placed({0, 0, 1}, M_PI - 0.1, Vector3d::UnitX());
    Isometry3d ceiling = placed({0, 0, 1}), raised = placed({3, 4, 9});
    ceiling.linear().diagonal() = raised.linear().diagonal() = Vector3d(1, -1, -1); // exactly half a turn
    expect_clear(sweep(a, floor, b, {ceiling, raised}));
    for (const RigidMotion& turn : {RigidMotion(ceiling, tilted), RigidMotion(ceiling, placed({0, 0, 1}))}) {
        const RigidMotion rest(floor), other(floor, placed({0, 0, 0}, 0.2, Vector3d::UnitX()));
        for (const SweepResult& r : {sweep(a, rest, b, turn), sweep(b, turn, a, rest), sweep(a, other, b, turn)}) {
            EXPECT_EQ(r.verdict, Verdict::colliding);
            EXPECT_EQ(r.clear_until, 0);
            EXPECT_LE(r.contact_by, 1e-4);
            EXPECT_EQ(r.gap, std::numeric_limits<double>::infinity()) << "they are 1 m apart at time 0";
        }
    }
}

TEST_F(Sweeps, AStepLimitLeavesThePairUndecided)
{
    Model &a = add(make_torus_mesh(2, 0.5, 500)), &b = add(make_torus_mesh(2, 0.5, 500));
    settings_.options.most_steps = 1;
    const SweepResult r = sweep(a, placed({0, 0, 0}), b, {placed({6, 1, 0}), placed({0, 0, 0}, 3, {1, 1, 0})});
    EXPECT_EQ(r.verdict, Verdict::undecided);
    EXPECT_LT(r.clear_until, 1);
    EXPECT_EQ(r.steps, 1);
}

TEST_F(Sweeps, TheGapIsWithinItsToleranceWhereTheBodiesSpeedUp)
{
    // At the key, a slow body is 1e-5 m from the wall; then it is a thousand times as fast.
    Model &wall = add(make_box_mesh({1, 5, 5})), &box = add(make_box_mesh({0.5, 0.5, 0.5}));
    const RigidMotion::Key keys[] = {
        {0, placed({2.5, 0, 0})}, {0.5, placed({1.5 + 1e-5, 0, 0})}, {1, placed({-998.5, 0, 0})}};
    const SweepResult r = sweep(wall, placed({0, 0, 0}), box, RigidMotion(keys));
    expect_contact(r, 0.5 + 0.5 * 1e-5 / 1000);
}

TEST_F(Sweeps, TenThousandPosesBeforeTheContactAreFree)
{
    Model &a = add(make_torus_knot_mesh(2, 3, 0.6, 0.25, 0.1, 600)), &b = add(make_torus_mesh(0.7, 0.2, 400));
    int contacts = 0;
    for (std::uint64_t seed = 0; contacts < 6; ++seed) {
        const RigidMotion motion_a(random_pose(4 * seed, 1), random_pose(4 * seed + 1, 1)),
            motion_b(random_pose(4 * seed + 2, 3), random_pose(4 * seed + 3, 3), MotionPath::screw);
        const SweepResult r = sweep(a, motion_a, b, motion_b);
        if (r.verdict != Verdict::colliding || r.contact_by == 0) continue;
        ++contacts;
        for (int n = 0; n < 10'000; ++n) {
            const double time = r.clear_until * (n == 9'999 ? 1 - 0x1p-52 : n / 9'999.0);
            ASSERT_EQ(decide(a, motion_a, b, motion_b, time).verdict, Verdict::separate) << seed << " at " << time;
        }
        EXPECT_EQ(decide(a, motion_a, b, motion_b, r.contact_by).verdict, Verdict::colliding);
    }
}

/// All pairs of kinds, in both orders, by single poses.
TEST_F(Sweeps, OfAllKindsAreClearUntilTheContactInBothOrders)
{
    int contacts = 0, clear = 0, at_start = 0, open = 0;
    for (std::uint64_t seed = 0; seed < 6; ++seed)
        for (std::size_t i = 0; i < std::size(every_kind); ++i)
            for (std::size_t k = 0; k < std::size(every_kind); ++k) {
                SCOPED_TRACE(testing::Message() << every_kind[i] << " " << every_kind[k] << " at " << seed);
                Model &a = add(draw_geometry(i, seed)), &b = add(draw_geometry(k, seed + 50));
                const std::uint64_t s = 1000 * seed + 30 * i + k;
                const MotionPath path = seed % 2 ? MotionPath::screw : MotionPath::linear;
                const RigidMotion motion_a(random_pose(4 * s, 1), random_pose(4 * s + 1, 1), path),
                    motion_b(random_pose(4 * s + 2, 3), random_pose(4 * s + 3, 3), path);
                settings_.clearance = seed % 3 == 2 ? 0.05 : 0;
                const SweepResult r = sweep(a, motion_a, b, motion_b), back = sweep(b, motion_b, a, motion_a);
                EXPECT_LE(r.clear_until, back.contact_by);
                EXPECT_LE(back.clear_until, r.contact_by);
                const auto meets = [&](double time) {
                    const Finding found = decide(a, motion_a, b, motion_b, time);
                    return found.verdict == Verdict::colliding || found.kind == ContactKind::near;
                };
                for (int n = 0; n < 60 && r.clear_until > 0; ++n) {
                    const double time = r.clear_until * (n == 59 ? 1 - 0x1p-52 : n / 59.0);
                    EXPECT_FALSE(meets(time)) << time << " of " << r.clear_until;
                }
                if (r.verdict == Verdict::separate) {
                    ++clear;
                    continue;
                }
                EXPECT_LE(r.contact_by - r.clear_until, 1e-4);
                open += r.verdict == Verdict::within && r.kind == ContactKind::unknown;
                ++(r.contact_by == 0 ? at_start : contacts);
                if (r.verdict == Verdict::colliding) {
                    EXPECT_TRUE(meets(r.contact_by));
                }
            }
    EXPECT_GT(contacts, 40);
    EXPECT_GT(clear, 20);
    EXPECT_GT(at_start, 20);
    RecordProperty("open", open);
}

} // namespace
} // namespace sweep_test
} // namespace oncollide
