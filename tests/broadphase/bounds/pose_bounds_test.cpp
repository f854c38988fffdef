#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/broadphase/bounds/pose_bounds.hpp>
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide {
namespace {

Eigen::Isometry3d random_pose(std::uint64_t seed, std::uint64_t i, double away)
{
    const Eigen::Vector3d axis(u01(seed, i, 0) - 0.5, u01(seed, i, 1) - 0.5, u01(seed, i, 2) - 0.5);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::AngleAxisd(6.28 * u01(seed, i, 3), axis.normalized()).toRotationMatrix();
    pose.translation() = Eigen::Vector3d(u01(seed, i, 4), u01(seed, i, 5), u01(seed, i, 6)) * away;
    return pose;
}

Aabb exact_box(const Mesh& mesh, const Eigen::Isometry3d& pose)
{
    Aabb box;
    for (const Triangle& t : mesh.triangles)
        for (std::uint32_t v : t) box.add(pose * mesh.vertices[v]);
    return box;
}

TEST(PoseBounds, EncloseRotatedMeshesTightlyBeforeAndAfterTheirMapIsMade)
{
    const Mesh meshes[] = {make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 3000), make_terrain_mesh(10, 1, 20, 3),
                           make_needles_mesh(300, 1, 1e4, 3, 5), make_box_mesh({1, 2, 3}), make_sphere_mesh(1, 5000)};
    for (const Mesh& mesh : meshes) {
        const GeometryData geometry = mesh;
        PoseBounds bounds(geometry);
        for (std::uint64_t i = 0; i < 3000; ++i) {
            const Eigen::Isometry3d pose = random_pose(1, i, i % 3 == 0 ? 1e6 : 10);
            const Aabb exact = exact_box(mesh, pose);
            if (i == 0) {
                EXPECT_TRUE(bounds.box(pose).contains(exact)) << "not prepared";
            }
            for (std::uint64_t k = 0; i == 1000 && k < 4096; ++k)
                bounds.expect(random_pose(3, k, 10)); // completes the map
            bounds.expect(pose);
            const Aabb box = bounds.box(pose);
            ASSERT_TRUE(box.contains(exact)) << "pose " << i;
            const double excess = std::max((exact.min - box.min).maxCoeff(), (box.max - exact.max).maxCoeff());
            ASSERT_LT(excess, 1e-5 * mesh.bounds.diagonal() + 1e-8) << "pose " << i;
            ASSERT_TRUE(bounds.sphere_box(pose).contains(exact));
        }
    }
}

/// Processes that share a scene must compute the same boxes, independent of their earlier queries of the mesh.
TEST(PoseBounds, DependOnThePoseAloneAndNotOnWhatWasRequestedBefore)
{
    for (const Mesh& mesh : {make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 3000), make_box_mesh({1, 2, 3})}) {
        const GeometryData geometry = mesh;
        PoseBounds fresh(geometry), used(geometry), complete(geometry);
        for (std::uint64_t i = 0; i < 700; ++i) used.expect(random_pose(2, i, 10));
        for (std::uint64_t i = 0; i < 4200; ++i) complete.expect(random_pose(2, i, 10));
        for (std::uint64_t i = 0; i < 200; ++i) {
            Eigen::Isometry3d pose = random_pose(1, i, 10);
            if (i < 10) pose.linear().setIdentity(); // first without rounding of floats
            const auto box = [&](PoseBounds& bounds) { return bounds.expect(pose), bounds.box(pose); };
            const Aabb a = box(fresh);
            for (const Aabb& b : {box(used), box(complete)}) {
                EXPECT_EQ(a.min, b.min) << i;
                EXPECT_EQ(a.max, b.max) << i;
            }
        }
    }
}

/// A large rotation and a large translation nearly cancel; the rounding error of the rest exceeds the precision of the
/// body's floats.
/// Also of a way whose ends are quarter turns, at which no map is needed.
TEST(PoseBounds, DependOnTheWayAloneAndNotOnWhatWasRequestedBefore)
{
    const GeometryData geometry = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 3000);
    for (std::uint64_t i = 0; i < 20; ++i) {
        PoseBounds used(geometry), fresh(geometry);
        for (std::uint64_t k = 0; k < 50 * i; ++k) used.expect(random_pose(5, k, 10));
        Eigen::Isometry3d from = random_pose(6, i, 10), to = random_pose(7, i, 10);
        if (i % 2) from.linear() = Eigen::Vector3d(-1, -1, 1).asDiagonal(), to.linear().setIdentity();
        const RigidMotion way(from, to);
        used.expect(way), fresh.expect(way);
        const Aabb box = fresh.box(way);
        ASSERT_EQ(used.box(way).min, box.min);
        ASSERT_EQ(used.box(way).max, box.max);
        for (int k = 0; k <= 40; ++k) {
            const Eigen::Isometry3d pose = way.pose(k / 40.0);
            ASSERT_TRUE(box.contains(exact_box(std::get<Mesh>(geometry), pose))) << i << " " << k;
        }
    }
}

TEST(PoseBounds, EncloseSmallMeshesOfFarFilesThatPosesTakeBack)
{
    using Vector3l = Eigen::Matrix<long double, 3, 1>;
    const Eigen::Vector3d far(1e8, -1e8, 5e7);
    const Mesh mesh = transformed("far", make_box_mesh({1, 1, 1}), 1e-4, -1e4 * far);
    const GeometryData geometry = mesh;
    PoseBounds bounds(geometry);
    for (std::uint64_t i = 0; i < 1000; ++i) {
        Eigen::Isometry3d pose = random_pose(2, i, 0);
        pose.translation() = pose.linear() * -far;
        if (i % 2) bounds.expect(pose);
        const Aabb box = bounds.box(pose), sphere = bounds.sphere_box(pose);
        for (const Eigen::Vector3d& v : mesh.vertices) {
            const Vector3l at =
                pose.linear().cast<long double>() * v.cast<long double>() + pose.translation().cast<long double>();
            for (int axis = 0; axis < 3; ++axis) {
                ASSERT_TRUE(at[axis] >= box.min[axis] && at[axis] <= box.max[axis]) << "pose " << i;
                ASSERT_TRUE(at[axis] >= sphere.min[axis] && at[axis] <= sphere.max[axis]) << "pose " << i;
            }
        }
    }
}

/// Without a rotation the extents are known exactly; far away, they are less than the rounding of the sums.
TEST(PoseBounds, EncloseShapesFarFromTheOrigin)
{
    const std::pair<Shape, Eigen::Vector3d> shapes[] = {{Sphere{0.1}, {0.1, 0.1, 0.1}},
                                                        {Box{{0.1, 0.2, 0.3}}, {0.1, 0.2, 0.3}},
                                                        {Capsule{0.1, 0.5}, {0.1, 0.1, 0.35}},
                                                        {Cylinder{0.1, 0.5}, {0.1, 0.1, 0.25}},
                                                        {Ellipsoid{{0.1, 0.2, 0.3}}, {0.1, 0.2, 0.3}},
                                                        {Cone{0.1, 0.5}, {0.1, 0.1, 0.25}}};
    for (const auto& [shape, half] : shapes) {
        const GeometryData geometry = shape;
        const PoseBounds bounds(geometry);
        for (std::uint64_t i = 0; i < 300; ++i) {
            Eigen::Isometry3d pose = random_pose(6, i, i % 2 ? 1e9 : 1e15);
            pose.linear().setIdentity();
            for (const Aabb& box : {bounds.box(pose), bounds.sphere_box(pose)})
                for (int axis = 0; axis < 3; ++axis) {
                    const long double at = pose.translation()[axis];
                    ASSERT_LE(box.min[axis], at - half[axis]) << shape.index() << ", pose " << i;
                    ASSERT_GE(box.max[axis], at + half[axis]) << shape.index() << ", pose " << i;
                }
        }
    }
}

TEST(PoseBounds, GiveAtMostATenthMoreCandidatesThanExactBoxesOnMany)
{
    Scene scene = make_scene("many", {.bodies = 400, .frames = {}, .seed = 12345, .data = {}});
    std::vector<PoseBounds> bounds;
    for (const Geometry& geometry : scene.geometries) bounds.emplace_back(geometry.data);
    std::vector<Aabb> tight(scene.size()), exact(scene.size());
    std::vector<std::uint32_t> all;
    for (std::uint32_t body = 0; body < scene.size(); ++body) all.push_back(body);
    Mover mover;
    std::size_t candidates = 0, least = 0;
    for (int frame = 0; frame < 16; ++frame) { // long enough that the maps are used
        mover.move(scene, frame);
        for (std::uint32_t body : all) {
            PoseBounds& own = bounds[index(scene.geometry[body])];
            own.expect(scene.poses[body]);
            tight[body] = own.box(scene.poses[body]);
        }
        if (frame % 5) continue;
        for (std::uint32_t body : all)
            exact[body] =
                exact_box(std::get<Mesh>(scene.geometries[index(scene.geometry[body])].data), scene.poses[body]);
        for (std::uint32_t a : all)
            for (std::uint32_t b = a + 1; b < scene.size(); ++b) {
                candidates += tight[a].overlaps(tight[b]);
                least += exact[a].overlaps(exact[b]);
            }
    }
    EXPECT_GT(least, 100u);
    EXPECT_LE(static_cast<double>(candidates), 1.1 * static_cast<double>(least));
}

TEST(PoseBounds, EncloseShapes)
{
    const Shape shapes[] = {Sphere{0.7},
                            Box{{1, 0.5, 2}},
                            Capsule{0.5, 2},
                            Cylinder{0.3, 1.5},
                            Ellipsoid{{0.3, 1, 2}},
                            Cone{1, 3},
                            ConvexHull{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 2}}}};
    for (const Shape& shape : shapes) {
        const GeometryData geometry = shape;
        PoseBounds bounds(geometry);
        const Mesh around = bounding_mesh_of(shape).mesh;
        for (std::uint64_t i = 0; i < 200; ++i) {
            const Eigen::Isometry3d pose = random_pose(2, i, 5);
            bounds.expect(pose);
            const Aabb box = bounds.box(pose), outer = exact_box(around, pose);
            // The enclosing mesh is larger than the shape by at most 1 % of its size.
            const Aabb rounded{outer.min.array() - 1e-5, outer.max.array() + 1e-5};
            EXPECT_TRUE(rounded.contains(box)) << shape.index();
            EXPECT_LT((box.min - outer.min).cwiseAbs().maxCoeff(), 0.02 * around.bounds.diagonal());
            EXPECT_LT((box.max - outer.max).cwiseAbs().maxCoeff(), 0.02 * around.bounds.diagonal());
        }
    }
}

TEST(PoseBounds, EncloseCylindersAndConesThatLeanALittle)
{
    for (int lean = 1; lean <= 52; ++lean)
        for (std::uint64_t turn = 0; turn < 20; ++turn) {
            const double angle = std::ldexp(1 + u01(7, std::uint64_t(lean), turn), -lean),
                         about = 6.28 * u01(8, 1, turn);
            Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
            pose.linear() =
                Eigen::AngleAxisd(angle, Eigen::Vector3d(std::cos(about), std::sin(about), 0)).toRotationMatrix();
            if (turn % 3 == 1) pose.linear() = pose.linear() * Eigen::AngleAxisd(about, Eigen::Vector3d::UnitZ());
            if (turn % 3 == 2) // along x instead
                pose.linear() = Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitY()) * pose.linear();
            const double radius = 0.75, half = 0.5;
            const Aabb cylinder = PoseBounds(GeometryData(Shape(Cylinder{radius, 2 * half}))).box(pose),
                       cone = PoseBounds(GeometryData(Shape(Cone{radius, 2 * half}))).box(pose);
            for (int axis = 0; axis < 3; ++axis) {
                const long double x = pose(axis, 0), y = pose(axis, 1),
                                  along = half * static_cast<long double>(pose(axis, 2)),
                                  across = radius * std::sqrt(x * x + y * y);
                EXPECT_GE(cylinder.max[axis], std::abs(along) + across) << lean << ' ' << axis;
                EXPECT_LE(cylinder.min[axis], -std::abs(along) - across) << lean << ' ' << axis;
                EXPECT_GE(cone.max[axis], std::max(along, across - along)) << lean << ' ' << axis;
                EXPECT_LE(cone.min[axis], std::min(along, -across - along)) << lean << ' ' << axis;
                EXPECT_LE(cylinder.max[axis], (std::abs(along) + across) * (1 + 1e-13L));
            }
        }
}

TEST(PoseBounds, NoPointMovesFartherThanTheMotion)
{
    const Mesh meshes[] = {make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300), make_terrain_mesh(10, 1, 20, 3)};
    for (Mesh mesh : meshes)
        for (const double offset : {0.0, 1e3}) { // of the mesh in its own frame
            for (Eigen::Vector3d& v : mesh.vertices) v.x() += offset;
            mesh.bounds = {};
            for (const Eigen::Vector3d& v : mesh.vertices) mesh.bounds.add(v);
            const GeometryData geometry = mesh;
            const PoseBounds bounds(geometry);
            for (std::uint64_t i = 0; i < 2000; ++i) {
                const double scale = std::pow(10.0, 1 - double(i % 9));
                const Eigen::Isometry3d from = random_pose(2, i, 100);
                const Eigen::AngleAxisd turn(i % 3 ? scale * u01(3, i, 0) : 0, random_pose(4, i, 1).linear().col(0));
                Eigen::Isometry3d to(turn * from.linear());
                to.translation() =
                    from.translation() + scale * Eigen::Vector3d(u01(3, i, 1), u01(3, i, 2), -u01(3, i, 3));
                // About the mesh's centre, so that far coordinates do not hide the rotation.
                to.translation() += (from.linear() - to.linear()) * mesh.bounds.centre();
                if (i % 5 == 0) to.linear() *= 1 + 4e-7 * (u01(3, i, 4) - 0.5);
                double most = 0;
                for (const Eigen::Vector3d& v : mesh.vertices) most = std::max(most, (to * v - from * v).norm());
                const double motion = bounds.motion(from, to), size = bounds.reach();
                EXPECT_LE(most, motion + 1e-13 * (100 + size));
                const double moved = scale * 1.75 * (1 + mesh.bounds.half_extent().norm());
                EXPECT_LE(motion, moved * 1.01 + 4e-6 * size) << scale;
                if (i % 3 == 0 && i % 5) {
                    EXPECT_LE(motion, most * (1 + 1e-5) + 1e-12 * (100 + size))
                        << "no larger than the translation, if unrotated";
                }
            }
            EXPECT_EQ(bounds.motion(random_pose(2, 0, 9), random_pose(2, 0, 9)), 0);
        }
}

} // namespace
} // namespace oncollide
