// The largest ball in the overlap of two meshes, against closed forms, linear programs and sampled points.
#include <cmath>
#include <numbers>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/overlap/common_ball.hpp>
#include <oncollide/narrowphase/overlap/cut_box.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/model/mesh.hpp>

#include "plate_with_hole.hpp"
#include "random_pose.hpp"

namespace oncollide {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;

const Isometry3d here = Isometry3d::Identity();

Mesh box_between(const Vector3d& low, const Vector3d& high)
{
    Mesh mesh = make_box_mesh((high - low) / 2);
    for (Vector3d& v : mesh.vertices) v += (low + high) / 2;
    return make_mesh("box", std::move(mesh.vertices), std::move(mesh.triangles));
}

/// Both meshes as one.
Mesh both_as_one(const Mesh& a, const Mesh& b)
{
    std::vector<Vector3d> vertices = a.vertices;
    std::vector<Triangle> triangles = a.triangles;
    vertices.insert(vertices.end(), b.vertices.begin(), b.vertices.end());
    const auto first = std::uint32_t(a.vertices.size());
    for (const Triangle& t : b.triangles) triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    return make_mesh("joined", std::move(vertices), std::move(triangles));
}

Mesh turned_inside_out(Mesh mesh)
{
    for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
    return mesh;
}

/// The depth of a point in a mesh, negative outside, from all triangles and solid angles.
double depth_in(const Mesh& mesh, const Isometry3d& pose, const Vector3d& point)
{
    double distance = 1e300, angle = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto c = corners_of(mesh, t);
        const Vector3d a = pose * c[0] - point, b = pose * c[1] - point, d = pose * c[2] - point;
        const double la = a.norm(), lb = b.norm(), ld = d.norm();
        angle += 2 * std::atan2(a.dot(b.cross(d)), la * lb * ld + a.dot(b) * ld + b.dot(d) * la + d.dot(a) * lb);
        // The nearest point of a triangle is the best of its corners, edges and, if above it, its plane.
        const std::array corners{a, b, d};
        const Vector3d normal = (b - a).cross(d - a).normalized();
        bool above = true;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vector3d &p = corners[k], e = corners[(k + 1) % 3] - p;
            distance = std::min(distance, (p + std::clamp(-p.dot(e) / e.squaredNorm(), 0.0, 1.0) * e).norm());
            above &= e.cross(-p).dot(normal) >= 0;
        }
        if (above) distance = std::min(distance, std::abs(a.dot(normal)));
    }
    return std::abs(angle) > 2 * std::numbers::pi ? distance : -distance;
}

/// Checks the ball at its centre, and the upper bound at points around it.
void check_by_points(const Mesh& a, const Isometry3d& pose_a, const Mesh& b, const Isometry3d& pose_b,
                     const CommonBall& found, std::uint64_t seed)
{
    const auto depth = [&](const Vector3d& p) { return std::min(depth_in(a, pose_a, p), depth_in(b, pose_b, p)); };
    if (found.radius_lower > 0) {
        EXPECT_GE(depth(found.centre), found.radius_lower * (1 - 1e-9));
    }
    Aabb box;
    for (const Vector3d& v : a.vertices) box.add(pose_a * v);
    for (std::uint64_t k = 0; k < 300; ++k) {
        Vector3d p;
        for (std::uint64_t i = 0; i < 3; ++i)
            p[int(i)] = box.min[int(i)] + u01(seed, k, i) * (box.max - box.min)[int(i)];
        if (found.radius_lower > 0 && k % 2)
            p = found.centre + found.radius_upper * (u01(seed, k, 4) * 2 - 1) * (p - found.centre).normalized();
        EXPECT_LE(depth(p), found.radius_upper * (1 + 1e-9)) << k;
    }
}

TEST(CommonBall, OfBoxesInLineHasHalfTheLeastExtent)
{
    const CommonBallOptions options{.most_boxes_for_volume = 2000};
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        Vector3d low, high;
        for (std::uint64_t k = 0; k < 3; ++k) low[int(k)] = u01(seed, 0, k) * 0.9, high[int(k)] = 1 + u01(seed, 1, k);
        const Isometry3d pose = random_pose(seed, 3.0);
        const CommonBall found =
            common_ball(box_between(Vector3d::Zero(), Vector3d::Ones()), pose, box_between(low, high), pose, options);
        const Vector3d extent = Vector3d::Ones() - low;
        const double radius = extent.minCoeff() / 2;
        EXPECT_LE(found.radius_lower, radius * (1 + 1e-12)) << seed;
        EXPECT_GE(found.radius_upper, radius * (1 - 1e-12)) << seed;
        EXPECT_LE(found.radius_upper, 1.02 * found.radius_lower) << seed;
        EXPECT_LE(found.volume_lower, extent.prod() * (1 + 1e-9)) << seed;
        EXPECT_GE(found.volume_upper, extent.prod() * (1 - 1e-9)) << seed;
        EXPECT_LE(found.volume_upper, 1.06 * found.volume_lower) << seed;
    }
}

TEST(CommonBall, OfTurnedBoxesIsThatOfALinearProgram)
{
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        const Vector3d half_a(0.2 + u01(seed, 5, 0), 0.2 + u01(seed, 5, 1), 0.2 + u01(seed, 5, 2)), half_b(1, 0.3, 0.1);
        const Isometry3d pose_a = random_pose(2 * seed, 0.3), pose_b = random_pose(2 * seed + 1, 0.3);
        // The planes n . x + r <= d.
        std::vector<std::pair<Vector3d, double>> planes;
        for (const auto& [half, pose] : {std::pair(half_a, pose_a), std::pair(half_b, pose_b)})
            for (int k = 0; k < 6; ++k) {
                const Vector3d n = pose.linear().col(k % 3) * (k < 3 ? 1 : -1);
                planes.emplace_back(n, half[k % 3] + n.dot(pose.translation()));
            }
        double truth = 0;
        const std::size_t count = planes.size();
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t j = i + 1; j < count; ++j)
                for (std::size_t k = j + 1; k < count; ++k)
                    for (std::size_t l = k + 1; l < count; ++l) {
                        Eigen::Matrix4d m;
                        Eigen::Vector4d d;
                        for (int row = 0; const std::size_t p : {i, j, k, l}) {
                            m.row(row) << planes[p].first.transpose(), 1;
                            d[row++] = planes[p].second;
                        }
                        if (std::abs(m.determinant()) < 1e-9) continue;
                        const Eigen::Vector4d x = m.partialPivLu().solve(d);
                        bool feasible = true;
                        for (const auto& [n, from] : planes) feasible &= n.dot(x.head<3>()) + x[3] <= from + 1e-12;
                        if (feasible) truth = std::max(truth, x[3]);
                    }
        const CommonBall found =
            common_ball(make_box_mesh(half_a), pose_a, make_box_mesh(half_b), pose_b, {.most_boxes_for_volume = 4000});
        EXPECT_LE(found.radius_lower, truth + 1e-12) << seed;
        EXPECT_GE(found.radius_upper, truth - 1e-12) << seed;
        EXPECT_LE(found.radius_upper, std::max(1.03 * found.radius_lower, 1e-9)) << seed;
        CutBox cut({-half_b, half_b}); // in the frame of b
        for (std::size_t p = 0; p < 6; ++p) {
            const Vector3d n = pose_b.linear().transpose() * planes[p].first;
            cut.keep(-n, planes[p].first.dot(pose_b.translation()) - planes[p].second);
        }
        EXPECT_LE(found.volume_lower, cut.volume() + 1e-9) << seed;
        EXPECT_GE(found.volume_upper, cut.volume() - 1e-9) << seed;
        if (cut.volume() > 1e-3) {
            EXPECT_LE(found.volume_upper, 1.06 * found.volume_lower) << seed;
        }
    }
}

TEST(CommonBall, OfRoundAndBranchedMeshesIsThatOfPoints)
{
    const Mesh meshes[] = {make_sphere_mesh(1, 300), make_torus_mesh(0.8, 0.3, 400),
                           make_gear_mesh(8, 0.6, 0.9, 0.3, 0.2), make_torus_knot_mesh(2, 3, 0.7, 0.3, 0.15, 600)};
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        const Mesh &a = meshes[seed % 4], &b = meshes[seed / 4 % 4];
        const Isometry3d pose_a = random_pose(seed, 0.4), pose_b = random_pose(100 + seed, 0.4);
        const CommonBall found = common_ball(a, pose_a, b, pose_b);
        EXPECT_LE(found.radius_upper, 1.06 * found.radius_lower + 1e-9) << seed;
        check_by_points(a, pose_a, b, pose_b, found, seed);
    }
}

TEST(CommonBall, OfFacesThatRoundingOverlapsIsAsThin)
{
    const Mesh wall = plate_with_hole({0, 0, 0}, {3, 2, 0.2}, {1, 0.5, 0}, {2, 1.5, 0.2});
    for (const double by : {1e-8, 1e-7, 1e-6})
        for (std::uint64_t seed = 0; seed < 30; ++seed) {
            const Isometry3d pose = random_pose(seed, seed % 2 ? 1000 : 3.0);
            const double enough = 5e-6;
            for (const Mesh& part :
                 {plate_with_hole({1 - by, 0.5 - by, 0.05}, {2 + by, 1.5 + by, 0.15}, {1.05, 0.55, 0}, {1.95, 1.45, 0}),
                  box_between({1 - by, 0.5 - by, -0.1}, {2 + by, 1.5 + by, 0.3}),
                  box_between({0.3, 0.2, 0.2 - by}, {0.9, 1.9, 1}), box_between({-1, -1, -1}, {by, 3, 4}),
                  box_between({3 - by, 2 - by, 0.2 - by}, {5, 5, 5})}) {
                const CommonBall found = common_ball(wall, pose, part, pose, {.enough = enough});
                EXPECT_LE(found.radius_upper, enough) << seed << " " << by;
                check_by_points(wall, pose, part, pose, found, seed);
            }
        }
}

TEST(CommonBall, OfAFilmAroundAWindowIsLargerIfItIsThicker)
{
    const Mesh wall = plate_with_hole({0, 0, 0}, {3, 2, 0.2}, {1, 0.5, 0}, {2, 1.5, 0.2});
    for (const double by : {1e-4, 1e-3, 1e-2}) {
        const Mesh window =
            plate_with_hole({1 - by, 0.5 - by, 0.05}, {2 + by, 1.5 + by, 0.15}, {1.05, 0.55, 0}, {1.95, 1.45, 0});
        const CommonBall found =
            common_ball(wall, here, window, here, {.enough = 5e-6, .most_boxes_for_volume = 20'000});
        EXPECT_GT(found.radius_lower, 0.4 * by) << by;
        // In a corner, (2 - sqrt(2)) by; there the search may end before it knows better than the width of the film.
        EXPECT_GE(found.radius_upper, (2 - std::sqrt(2)) * by) << by;
        EXPECT_LE(found.radius_upper, 1.05 * by) << by;
        const double volume = 0.1 * (4 * by + 4 * by * by);
        EXPECT_LE(found.volume_lower, volume * (1 + 1e-9)) << by;
        EXPECT_GE(found.volume_upper, volume * (1 - 1e-9)) << by;
        EXPECT_LE(found.volume_upper, 1.06 * found.volume_lower) << by;
    }
}

TEST(CommonBall, KnowsInsideFromOutside)
{
    const Mesh cube = box_between({-1, -1, -1}, {1, 1, 1}), small = box_between({-.2, -.2, -.2}, {.2, .2, .2});
    const CommonBall enclosed = common_ball(cube, here, small, here);
    EXPECT_NEAR(enclosed.radius_lower, 0.2, 0.01);
    EXPECT_GE(enclosed.radius_upper, 0.2);
    const Mesh hollow = both_as_one(cube, turned_inside_out(box_between({-.5, -.5, -.5}, {.5, .5, .5})));
    const CommonBall in_hollow = common_ball(hollow, here, small, here, {.most_boxes_for_volume = 1000});
    EXPECT_EQ(in_hollow.radius_lower, 0);
    EXPECT_LT(in_hollow.radius_upper, 1e-9);
    EXPECT_LT(in_hollow.radius_upper, 1e-9);
    const CommonBall shell = common_ball(hollow, here, cube, here);
    EXPECT_GE(shell.radius_lower, 0.25);
    EXPECT_LE(shell.radius_lower, 0.5) << "in an edge there is more room than in a wall";
    const CommonBall same = common_ball(turned_inside_out(cube), here, cube, here, {.most_boxes_for_volume = 1000});
    EXPECT_NEAR(same.radius_lower, 1, 0.05);
    EXPECT_NEAR(same.volume_lower, 8, 0.4);
    const CommonBall apart = common_ball(cube, here, box_between({1.1, 0, 0}, {2, 1, 1}), here);
    EXPECT_EQ(apart.radius_upper, 0);
    // Two solids of one mesh that meet in an edge, beside a third one.
    const Mesh pair = both_as_one(box_between({0, 0, 0}, {1, 1, 1}), box_between({1, 1, 0}, {2, 2, 1}));
    const CommonBall beside =
        common_ball(pair, here, box_between({1 - 1e-9, 0, 0}, {2, 1 + 1e-9, 1}), here, {.enough = 1e-6});
    EXPECT_LE(beside.radius_upper, 1e-6);
}

TEST(CommonBall, BoundsStayTrueWhenTheSearchIsCutShort)
{
    const Mesh bar = box_between({-1, -.05, -.05}, {1, .05, .05}), other = box_between({-.05, -1, -.05}, {.05, 1, .05});
    for (const int boxes : {1, 2, 3, 10, 30, 100}) {
        const CommonBall found = common_ball(bar, here, other, here,
                                             {.relative = 1e-6, .most_boxes = boxes, .most_boxes_for_volume = boxes});
        EXPECT_LE(found.radius_lower, 0.05) << boxes;
        EXPECT_GE(found.radius_upper, 0.05) << boxes;
        EXPECT_LE(found.volume_lower, 1e-3 * (1 + 1e-9)) << boxes;
        EXPECT_GE(found.volume_upper, 1e-3 * (1 - 1e-9)) << boxes;
    }
}

TEST(CutBox, HasTheVolumeOfWhatIsKept)
{
    CutBox corner({Vector3d::Zero(), Vector3d::Ones()});
    corner.keep(-Vector3d::Ones().normalized(), -0.5 / std::sqrt(3.0));
    EXPECT_NEAR(corner.volume(), 1.0 / 48, 1e-15) << "a corner of side 1/2";
    CutBox half({Vector3d::Zero(), Vector3d(2, 3, 4)});
    half.keep({1, 0, 0}, 0.5);
    EXPECT_NEAR(half.volume(), 18, 1e-12);
    half.keep({0, 1, 0}, -1), half.keep({0, 0, -1}, -4);
    EXPECT_NEAR(half.volume(), 18, 1e-12) << "planes beside it";
    half.keep({0, 1, 0}, 3.5);
    EXPECT_EQ(half.volume(), 0);
}

} // namespace
} // namespace oncollide
