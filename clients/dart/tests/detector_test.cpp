// The detector as DART's users call it: shapes, filters, caps, groups, distances, rays.
#include <cmath>
#include <numbers>
#include <sstream>

#include <gtest/gtest.h>

#include "scenes.hpp"

namespace dart::collision::oncollide_client {

using dynamics::SimpleFrame;
using Eigen::Vector3d;
using FramePtr = std::shared_ptr<SimpleFrame>;

/// A frame with a shape.
FramePtr placed(dynamics::ShapePtr shape, const Vector3d& at = Vector3d::Zero(),
                const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity())
{
    auto frame = SimpleFrame::createShared(dynamics::Frame::World());
    frame->setShape(std::move(shape));
    frame->setTranslation(at), frame->setRotation(turn);
    return frame;
}

template <class T, class... Args>
dynamics::ShapePtr make(Args&&... args)
{
    return std::make_shared<T>(std::forward<Args>(args)...);
}

dynamics::ShapePtr sphere(double radius)
{
    return make<dynamics::SphereShape>(radius);
}

dynamics::ShapePtr box(double side)
{
    return make<dynamics::BoxShape>(Vector3d::Constant(side));
}

std::vector<dynamics::ShapePtr> every_shape()
{
    auto heights = std::make_shared<dynamics::HeightmapShapef>();
    heights->setHeightField(3, 3, {0, 0.02F, 0, 0.02F, 0.05F, 0.02F, 0, 0.02F, 0});
    auto voxels = std::make_shared<dynamics::VoxelGridShape>(0.25);
    for (const double x : {-0.1, 0.1})
        for (const double z : {-0.1, 0.1}) voxels->updateOccupancy(Vector3d(x, 0.1, z), true);
    return {sphere(0.5),
            box(1),
            make<dynamics::EllipsoidShape>(Vector3d(1, 0.8, 0.6)),
            make<dynamics::CapsuleShape>(0.4, 0.5),
            make<dynamics::CylinderShape>(0.5, 1.0),
            make<dynamics::ConeShape>(0.5, 1.0),
            make<dynamics::PyramidShape>(1.0, 1.0, 1.0),
            make<dynamics::PlaneShape>(Vector3d(0, 0.6, 0.8), 0.2),
            make<dynamics::MultiSphereConvexHullShape>(
                dynamics::MultiSphereConvexHullShape::Spheres{{0.3, Vector3d(0.2, 0, 0)}, {0.2, Vector3d(-0.2, 0, 0)}}),
            tests::mesh_shape(tests::box_mesh(Vector3d::Ones(), 2)),
            heights,
            voxels};
}

struct OncollideDetector : testing::Test {
    std::shared_ptr<CollisionDetector> detector = OncollideCollisionDetector::create();
    CollisionOption option{true, 1000, nullptr};
    CollisionResult result;

    bool meet(const FramePtr& a, const FramePtr& b)
    {
        return detector->createCollisionGroup(a.get(), b.get())->collide(option, &result);
    }
};

TEST_F(OncollideDetector, IsInTheFactory)
{
    const auto made = CollisionDetector::getFactory()->create("oncollide");
    ASSERT_TRUE(made);
    EXPECT_EQ(made->getType(), "oncollide");
    EXPECT_EQ(made->cloneWithoutCollisionObjects()->getType(), "oncollide");
}

TEST_F(OncollideDetector, FindsContactsOfEveryShapeWithEveryOther)
{
    const auto shapes = every_shape();
    std::vector<FramePtr> keep; // the models, from pair to pair
    const auto all = detector->createCollisionGroup();
    for (const auto& shape : shapes) keep.push_back(placed(shape)), all->addShapeFrame(keep.back().get());
    for (const auto& a : shapes)
        for (const auto& b : shapes) {
            const std::string names = a->getType() + " and " + b->getType();
            const bool planes = a->is<dynamics::PlaneShape>() && b->is<dynamics::PlaneShape>();
            const bool surfaces = a->is<dynamics::HeightmapShapef>() && (b->is<dynamics::HeightmapShapef>() || planes);
            if (planes || surfaces) continue; // never a pair; two surfaces may meet edge on
            const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.3, Vector3d(1, 2, 3).normalized()).matrix();
            EXPECT_TRUE(meet(placed(a), placed(b, {0.15, 0.05, 0.1}, turn))) << names;
            ASSERT_GT(result.getNumContacts(), 0u) << names;
            EXPECT_LE(result.getNumContacts(), 64u) << names;
            for (const Contact& contact : result.getContacts()) {
                EXPECT_NEAR(contact.normal.norm(), 1, 1e-12) << names;
                EXPECT_TRUE(contact.point.allFinite()) << names;
                EXPECT_GE(contact.penetrationDepth, 0) << names;
                EXPECT_LT(contact.penetrationDepth, 3) << names;
            }
            if (!a->is<dynamics::PlaneShape>() && !b->is<dynamics::PlaneShape>()) {
                EXPECT_FALSE(meet(placed(a), placed(b, {3, 0.1, 0.2}, turn))) << names;
                EXPECT_EQ(result.getNumContacts(), 0u) << names;
            }
        }
}

TEST_F(OncollideDetector, PointsNormalsFromTheSecondObjectToTheFirst)
{
    const auto ground = placed(make<dynamics::PlaneShape>(Vector3d(0, 0.6, 0.8), 2.0));
    for (const auto& shape : {sphere(0.5), tests::mesh_shape(tests::box_mesh(Vector3d::Ones(), 1))}) {
        const auto body = placed(shape, Vector3d(0, 0.6, 0.8) * 2.49,
                                 Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), Vector3d(0, 0.6, 0.8)).matrix());
        ASSERT_TRUE(meet(body, ground));
        EXPECT_EQ(result.getNumContacts(), shape->is<dynamics::SphereShape>() ? 1u : 4u);
        for (const Contact& contact : result.getContacts()) {
            EXPECT_EQ(contact.collisionObject1->getShapeFrame(), body.get());
            EXPECT_TRUE(contact.normal.isApprox(Vector3d(0, 0.6, 0.8), 1e-9)) << contact.normal.transpose();
            EXPECT_NEAR(contact.penetrationDepth, 0.01, 1e-9);
            EXPECT_NEAR(contact.point.dot(Vector3d(0, 0.6, 0.8)), 1.995, 1e-9); // halfway
        }
    }
}

TEST_F(OncollideDetector, SeesAMeshInAMesh)
{
    const auto outer = placed(tests::mesh_shape(tests::box_mesh(Vector3d::Constant(2), 2)));
    for (const auto& shape : {tests::mesh_shape(tests::box_mesh(Vector3d::Constant(0.5), 1)), box(0.5)}) {
        ASSERT_TRUE(meet(outer, placed(shape, {0.6, 0.1, 0})));
        ASSERT_GT(result.getNumContacts(), 0u);
        EXPECT_TRUE(result.getContact(0).normal.isApprox(-Vector3d::UnitX(), 1e-9)); // out through the nearest side
        EXPECT_NEAR(result.getContact(0).penetrationDepth, 0.65, 0.01);
    }
}

TEST_F(OncollideDetector, GivesEachContactOnACurvedSurfaceItsOwnNormal)
{
    const auto ring = placed(tests::mesh_shape(tests::ring_mesh(0.505, 1, 0.5, 128)));
    const auto shaft = placed(tests::mesh_shape(tests::ring_mesh(0, 0.5, 1, 128)), {0.006, 0, 0});
    ASSERT_TRUE(meet(ring, shaft)); // along an arc of 67 degrees
    EXPECT_GE(result.getNumContacts(), 4u);
    for (const Contact& contact : result.getContacts()) {
        const Vector3d radial(contact.point.x(), contact.point.y(), 0);
        EXPECT_GT(contact.normal.dot(radial.normalized()), std::cos(0.07)) << contact.point.transpose(); // a facet
    }
}

/// Ten pairs of boxes; pair i is i millimetres deep.
std::vector<FramePtr> ten_pairs()
{
    std::vector<FramePtr> frames;
    for (int i = 1; i <= 10; ++i)
        for (const double z : {0.0, 1.0 - 0.001 * i}) frames.push_back(placed(box(1), {3.0 * i, 0, z}));
    return frames;
}

TEST_F(OncollideDetector, SharesACapAmongAllPairs)
{
    const auto frames = ten_pairs();
    const auto group = detector->createCollisionGroup();
    for (const auto& frame : frames) group->addShapeFrame(frame.get());
    for (const auto& [cap, least, most] : {std::tuple(40, 4, 4), std::tuple(25, 2, 3), std::tuple(10, 1, 1)}) {
        option.maxNumContacts = static_cast<std::size_t>(cap);
        std::ostringstream said;
        std::streambuf* before = std::cerr.rdbuf(said.rdbuf());
        ASSERT_TRUE(group->collide(option, &result));
        std::cerr.rdbuf(before);
        EXPECT_EQ(said.str().find("40 contacts") != std::string::npos, cap == 25) << said.str(); // said once
        EXPECT_EQ(result.getNumContacts(), option.maxNumContacts);
        std::map<const CollisionObject*, int> count;
        for (const Contact& contact : result.getContacts()) ++count[contact.collisionObject1];
        EXPECT_EQ(count.size(), 10u);
        for (const auto& [object, n] : count) EXPECT_TRUE(n >= least && n <= most) << n;
    }
    option.maxNumContacts = 3; // the three deepest pairs
    ASSERT_TRUE(group->collide(option, &result));
    for (const Contact& contact : result.getContacts()) EXPECT_GE(contact.penetrationDepth, 0.0075);
    EXPECT_EQ(result.getNumContacts(), 3u);
}

struct IgnoreOne : CollisionFilter {
    const dynamics::ShapeFrame* frame = nullptr;
    bool ignoresCollision(const CollisionObject* a, const CollisionObject* b) const override
    {
        return a->getShapeFrame() == frame || b->getShapeFrame() == frame;
    }
};

TEST_F(OncollideDetector, AsksTheFilterInEveryCall)
{
    const auto a = placed(box(1)), b = placed(box(1), {0.5, 0, 0}), c = placed(box(1), {1.2, 0, 0});
    const auto group = detector->createCollisionGroup(a.get(), b.get(), c.get());
    const auto filter = std::make_shared<IgnoreOne>();
    option.collisionFilter = filter;
    filter->frame = a.get();
    EXPECT_TRUE(group->collide(option, &result));
    EXPECT_FALSE(result.inCollision(a.get()));
    EXPECT_TRUE(result.inCollision(c.get()));
    filter->frame = b.get();
    EXPECT_FALSE(group->collide(option, &result));
    EXPECT_FALSE(group->collide(option));
    EXPECT_TRUE(group->collide());
    filter->frame = c.get();
    EXPECT_TRUE(group->collide(option));
}

TEST_F(OncollideDetector, TestsGroupsAgainstEachOtherOnly)
{
    const auto a = placed(box(1)), b = placed(box(1), {0.5, 0, 0}), c = placed(box(1), {5, 0, 0});
    const auto ab = detector->createCollisionGroup(a.get(), b.get()), only_c = detector->createCollisionGroup(c.get());
    const auto bc = detector->createCollisionGroup(b.get(), c.get());
    EXPECT_TRUE(ab->collide(option, &result));
    EXPECT_FALSE(ab->collide(only_c.get(), option, &result)); // a and b meet, but both are of one group
    EXPECT_FALSE(only_c->collide(option, &result));
    EXPECT_TRUE(ab->collide(bc.get(), option, &result)); // a with b, which is in both
    EXPECT_FALSE(result.inCollision(c.get()));
    c->setTranslation({1, 0, 0});
    EXPECT_TRUE(only_c->collide(ab.get(), option, &result));
    EXPECT_FALSE(result.inCollision(a.get()) && result.getNumContacts() == 0);
    EXPECT_EQ(result.getContact(0).collisionObject1->getShapeFrame(), c.get());             // of the first group
    EXPECT_FALSE(OncollideCollisionDetector::create()->collide(ab.get(), option, &result)); // another's group
}

TEST_F(OncollideDetector, FollowsChangesOfShapesAndMembers)
{
    const auto shape = std::make_shared<dynamics::BoxShape>(Vector3d::Ones());
    const auto a = placed(shape), b = placed(shape, {1.2, 0, 0}), c = placed(box(1), {0, 5, 0});
    const auto group = detector->createCollisionGroup(a.get(), b.get());
    EXPECT_FALSE(group->collide());
    shape->setSize(Vector3d::Constant(1.3)); // a version of a shape that two objects share
    EXPECT_TRUE(group->collide());
    b->setShape(sphere(0.5));
    EXPECT_FALSE(group->collide());
    group->addShapeFrame(c.get());
    c->setTranslation({0, 0.9, 0});
    EXPECT_TRUE(group->collide());
    group->removeShapeFrame(c.get());
    EXPECT_FALSE(group->collide());
    b->setShape(nullptr);
    EXPECT_FALSE(group->collide());
    b->setShape(box(2));
    EXPECT_TRUE(group->collide());
    group->removeAllShapeFrames();
    EXPECT_FALSE(group->collide());
}

TEST_F(OncollideDetector, LeavesOutWhatItDoesNotKnow)
{
    const auto line = placed(make<dynamics::LineSegmentShape>(Vector3d(-1, 0, 0), Vector3d(1, 0, 0), 1.0F));
    std::ostringstream said;
    std::streambuf* before = std::cerr.rdbuf(said.rdbuf());
    EXPECT_FALSE(meet(line, placed(box(1))));
    const auto lost = placed(box(1));
    lost->setTranslation({std::nan(""), 0, 0});
    EXPECT_FALSE(meet(lost, placed(box(1))));
    std::cerr.rdbuf(before);
    EXPECT_NE(said.str().find("LineSegmentShape"), std::string::npos) << said.str();
    EXPECT_NE(said.str().find("such objects have no contacts"), std::string::npos) << said.str();
}

struct IgnoreDistance : DistanceFilter {
    const dynamics::ShapeFrame* frame = nullptr;
    bool needDistance(const CollisionObject* a, const CollisionObject* b) const override
    {
        return a->getShapeFrame() != frame && b->getShapeFrame() != frame;
    }
};

TEST_F(OncollideDetector, FindsTheLeastDistanceOfAllPairs)
{
    const auto a = placed(sphere(1)), b = placed(sphere(1), {2.5, 0, 0}), c = placed(sphere(1), {0, 0, 9});
    const auto group = detector->createCollisionGroup(c.get(), a.get(), b.get());
    DistanceOption distance(true, 0, nullptr);
    DistanceResult found;
    EXPECT_DOUBLE_EQ(group->distance(distance, &found), 0.5); // FCL returns the last pair's
    EXPECT_EQ(found.shapeFrame1, a.get());
    EXPECT_EQ(found.shapeFrame2, b.get());
    EXPECT_TRUE(found.nearestPoint1.isApprox(Vector3d(1, 0, 0), 1e-12));
    const auto filter = std::make_shared<IgnoreDistance>();
    filter->frame = b.get(), distance.distanceFilter = filter;
    EXPECT_DOUBLE_EQ(group->distance(distance, &found), 7);
    const auto only_a = detector->createCollisionGroup(a.get()), only_b = detector->createCollisionGroup(b.get());
    EXPECT_DOUBLE_EQ(only_a->distance(only_b.get()), 0.5);
    b->setTranslation({1.9, 0, 0});
    EXPECT_DOUBLE_EQ(only_a->distance(only_b.get()), 0);
    EXPECT_NEAR(only_a->distance(only_b.get(), DistanceOption(false, -1, nullptr)), -0.1, 0.002);
    EXPECT_DOUBLE_EQ(only_a->distance(only_b.get(), DistanceOption(false, 0.7, nullptr)), 0.7);
    EXPECT_EQ(only_a->distance(), 0);
}

TEST_F(OncollideDetector, CastsRaysAtOneGroup)
{
    const auto a = placed(sphere(1), {5, 0, 0}), b = placed(box(2), {9, 0, 0}), c = placed(box(1), {2, 0, 0});
    const auto group = detector->createCollisionGroup(b.get(), a.get()),
               other = detector->createCollisionGroup(c.get());
    RaycastResult hits;
    const Vector3d from = Vector3d::Zero(), to(10, 0, 0);
    EXPECT_TRUE(group->raycast(from, to, RaycastOption(), &hits));
    ASSERT_EQ(hits.mRayHits.size(), 1u);
    EXPECT_EQ(hits.mRayHits[0].mCollisionObject->getShapeFrame(), a.get());
    EXPECT_NEAR(hits.mRayHits[0].mFraction, 0.4, 1e-11);
    EXPECT_TRUE(group->raycast(from, to, RaycastOption(true, true), &hits));
    ASSERT_EQ(hits.mRayHits.size(), 2u);
    EXPECT_EQ(hits.mRayHits[1].mCollisionObject->getShapeFrame(), b.get());
    EXPECT_TRUE(hits.mRayHits[1].mPoint.isApprox(Vector3d(8, 0, 0), 1e-12));
    EXPECT_TRUE(hits.mRayHits[1].mNormal.isApprox(-Vector3d::UnitX(), 1e-12));
    EXPECT_TRUE(other->raycast(from, to));
    EXPECT_FALSE(group->raycast(from, {0, 10, 0}, RaycastOption(), &hits));
    EXPECT_FALSE(group->raycast(from, from));
}

TEST_F(OncollideDetector, MakesHeightmapsSolidOnRequest)
{
    auto heights = std::make_shared<dynamics::HeightmapShaped>();
    heights->setHeightField(2, 2, {1, 2, 1, 2}); // rises along x from -0.5 to 0.5
    const auto inside = placed(sphere(0.05), {0, 0, 0.5}), above = placed(sphere(0.05), {0, 0, 1.6});
    EXPECT_FALSE(meet(placed(heights), inside));
    EXPECT_FALSE(meet(placed(heights), above));
    detector = OncollideCollisionDetector::create({.solidHeightmaps = true});
    EXPECT_TRUE(meet(placed(heights), inside));
    EXPECT_FALSE(meet(placed(heights), above));
    EXPECT_FALSE(meet(placed(heights), placed(sphere(0.05), {0, 0, -0.06}))); // below the floor
}

// --- In simulations.

TEST(OncollideSimulation, AStackOfMeshesComesToRest)
{
    for (const int cuts : {1, 4}) {
        auto world = tests::stack(OncollideCollisionDetector::create(), 3, cuts);
        for (int i = 0; i < 1000; ++i) world->step();
        const Vector3d before = world->getSkeleton("body 2")->getRootBodyNode()->getTransform().translation();
        for (int i = 0; i < 500; ++i) world->step();
        for (int k = 0; k < 3; ++k) {
            const auto* body = world->getSkeleton("body " + std::to_string(k))->getRootBodyNode();
            EXPECT_NEAR(body->getTransform().translation().z(), k + 0.5, 1e-4) << cuts;
        }
        const Vector3d after = world->getSkeleton("body 2")->getRootBodyNode()->getTransform().translation();
        EXPECT_LT((after - before).head<2>().norm() / 0.5, 1e-8) << cuts; // metres per second
        EXPECT_LE(world->getLastCollisionResult().getNumContacts(), 12u) << cuts;
    }
}

TEST(OncollideSimulation, ThreadsChangeNothing)
{
    std::vector<Eigen::Matrix4d> ends;
    for (const int threads : {1, 3}) {
        auto world = tests::stack(OncollideCollisionDetector::create({.threads = threads}), 3, 2);
        for (int i = 0; i < 200; ++i) world->step();
        ends.push_back(world->getSkeleton("body 2")->getRootBodyNode()->getTransform().matrix());
    }
    EXPECT_EQ(ends[0], ends[1]);
}

TEST(OncollideSimulation, TheSkinOfASoftBoxStaysOnTheGround)
{
    auto world = simulation::World::create();
    world->getConstraintSolver()->setCollisionDetector(OncollideCollisionDetector::create());
    world->addSkeleton(tests::fixed(make<dynamics::PlaneShape>(Vector3d::UnitZ(), 0.0), "ground"));
    auto soft = dynamics::Skeleton::create("soft");
    dynamics::SoftBodyNode::Properties properties(
        dynamics::BodyNode::Properties(),
        dynamics::SoftBodyNodeHelper::makeBoxProperties(Vector3d::Constant(0.4), Eigen::Isometry3d::Identity(),
                                                        Eigen::Vector3i::Constant(3), 1.0));
    auto [joint, body] = soft->createJointAndBodyNodePair<dynamics::FreeJoint, dynamics::SoftBodyNode>(
        nullptr, dynamics::FreeJoint::Properties(), properties);
    joint->setTransform(Eigen::Isometry3d(Eigen::Translation3d(0, 0, 0.25)));
    world->addSkeleton(soft);
    for (int i = 0; i < 150; ++i) world->step(); // the body sags; its skin stays on the ground
    EXPECT_GE(world->getLastCollisionResult().getNumContacts(), 4u);
    for (std::size_t i = 0; i < body->getNumPointMasses(); ++i)
        EXPECT_GT(body->getPointMass(i)->getWorldPosition().z(), -0.006) << i; // with FCL's detector -0.06
}

} // namespace dart::collision::oncollide_client
