// The least translation that parts two solids, against closed forms and a search over directions.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include <fmt/format.h>

#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/shapes/least_translation.hpp>

#include "random_pose.hpp"

namespace oncollide::least_translation_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

struct Solid {
    Model model;
    explicit Solid(Shape shape) : model(std::make_shared<const Geometry>(Geometry{"shape", std::move(shape), {}})) {}
};

LeastTranslation least(Model& a, const Isometry3d& pose_a, Model& b, const Isometry3d& pose_b, double cutoff = 1e9)
{
    const PlacedPair placed(pose_a, pose_b);
    return least_translation(ConvexDifference(a.convex(), b.convex(), placed.b_to_a, placed.slack), cutoff);
}

/// The largest projection of a solid onto a direction (world).
double most_along(Model& model, const Isometry3d& pose, const Vector3d& d)
{
    const Vector3d own = pose.linear().transpose() * d;
    const Convex& c = model.convex();
    return d.dot(pose.translation()) + own.dot(c.support(own)) + c.radius * own.norm();
}

/// How far b must move along d (world, unit) to be beyond a.
double width(Model& a, const Isometry3d& pose_a, Model& b, const Isometry3d& pose_b, const Vector3d& d)
{
    return most_along(a, pose_a, d) + most_along(b, pose_b, -d);
}

struct Drawing {
    std::mt19937_64 random;
    double draw(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
    Vector3d direction() { return Vector3d(draw(-1, 1), draw(-1, 1), draw(-1, 1)).normalized(); }
    Shape shape(int kind, double size)
    {
        const auto length = [&] { return size * draw(0.2, 0.5); };
        switch (kind) {
        case 0:
            return Sphere{length()};
        case 1:
            return Capsule{length(), 2 * length()};
        case 2:
            return Box{{length(), length(), length()}};
        case 3:
            return Cylinder{length(), 2 * length()};
        case 4:
            return Cone{length(), 2 * length()};
        case 5:
            return Ellipsoid{{length(), length(), length()}};
        default: {
            ConvexHull hull;
            const int points = 4 + int(random() % 60);
            for (int i = 0; i < points; ++i) hull.points.push_back(size * 0.5 * direction());
            return hull;
        }
        }
    }
};

TEST(LeastTranslation, IsCertifiedAndLeastForEveryTwoShapes)
{
    Drawing d{std::mt19937_64(5)};
    std::size_t overlap = 0, loose = 0;
    for (int trial = 0; trial < 4000; ++trial) {
        const int kind_a = int(d.random() % 7), kind_b = int(d.random() % 7);
        const std::string where = fmt::format("trial {}, kinds {} and {}", trial, kind_a, kind_b);
        Solid a(d.shape(kind_a, 1)), b(d.shape(kind_b, trial % 3 ? 1 : 0.05));
        const Isometry3d pose_a = random_pose(d.random(), 0.5), pose_b = random_pose(d.random(), 0.5);
        const LeastTranslation found = least(a.model, pose_a, b.model, pose_b);
        const Vector3d n = pose_a.linear() * found.normal;
        ASSERT_NEAR(n.norm(), 1, 1e-12) << where;
        ASSERT_LE(found.lower, found.upper) << where;
        const double along = width(a.model, pose_a, b.model, pose_b, n);
        EXPECT_LE(along, found.upper + 1e-14) << where;
        if (found.lower > 0) {
            ++overlap;
            EXPECT_LE(found.upper, along + 1e-12) << where;
            loose += found.upper > 1.01 * found.lower + 1e-6;
        }
        // No direction is better than the lower bound; descent from several starts.
        Vector3d best = n;
        double least_width = along;
        for (int start = 0; start < 6; ++start) {
            Vector3d from = start == 0 ? n : d.direction();
            double here = width(a.model, pose_a, b.model, pose_b, from);
            for (double step = 0.5; step > 1e-7; step /= 2)
                for (int k = 0; k < 8; ++k) {
                    const Vector3d next = (from + step * d.direction()).normalized();
                    if (const double w = width(a.model, pose_a, b.model, pose_b, next); w < here) from = next, here = w;
                }
            if (here < least_width) least_width = here, best = from;
        }
        EXPECT_GE(least_width, found.lower - 1e-13) << where;
    }
    EXPECT_GT(overlap, 1500u);
    EXPECT_EQ(loose, 0u);
}

TEST(LeastTranslation, AgreesWithClosedForms)
{
    const auto at = [](double x, double y, double z) { return Isometry3d(Eigen::Translation3d(x, y, z)); };
    Solid ball(Sphere{0.5}), small(Sphere{0.25}), box(Box{{1, 0.5, 0.25}}), rod(Capsule{0.25, 2});
    const auto expect = [&](Solid& a, const Isometry3d& pose_a, Solid& b, const Isometry3d& pose_b, double depth,
                            const Vector3d& normal) {
        const LeastTranslation found = least(a.model, pose_a, b.model, pose_b);
        EXPECT_NEAR(found.lower, depth, 1e-13);
        EXPECT_NEAR(found.upper, depth, 1e-13);
        EXPECT_LE(found.lower, depth);
        EXPECT_GE(found.upper, depth);
        if (!normal.isZero(0)) {
            EXPECT_NEAR((found.normal - normal).norm(), 0, 1e-12);
        }
    };
    expect(ball, at(0, 0, 0), small, at(0, 0.7, 0), 0.05, {0, 1, 0});
    expect(ball, at(0, 0, 0), small, at(0, 0.8, 0), -0.05, {0, 1, 0});
    expect(ball, at(1, 2, 3), small, at(1, 2, 3), 0.75, Vector3d::Zero());
    expect(box, at(0, 0, 0), ball, at(0.1, 0.2, 0.7), 0.05, {0, 0, 1});
    expect(box, at(0, 0, 0), ball, at(0.1, 0.2, 0.2), 0.55, {0, 0, 1});
    expect(box, at(0, 0, 0), rod, at(0, 0.7, 0), 0.05, {0, 1, 0});
    expect(rod, at(0, 0, 0), rod, at(0.4, 0, 1.5), 0.1, {1, 0, 0});
    expect(rod, at(0, 0, 0), rod, at(0, 0, 2.4), 0.1, {0, 0, 1});
    expect(rod, at(0, 0, 0), rod, at(0, 0, 0.3), 0.5, Vector3d::Zero()); // on one axis: across it
    expect(box, at(0, 0, 0), box, at(0.1, 0.2, 0.45), 0.05, {0, 0, 1});
    expect(box, at(0, 0, 0), box, at(0.1, 0.2, 0.55), -0.05, {0, 0, 1});
}

/// Random hulls of 4 to 200 points: duplicates, points in one plane, needles, and far from the origin.
TEST(LeastTranslation, TakesHullsOfEveryForm)
{
    Drawing d{std::mt19937_64(11)};
    std::size_t shapes = 0;
    for (int trial = 0; trial < 400; ++trial) {
        const int form = trial % 5;
        const double far = form == 4 ? 1e6 : 0;
        ConvexHull hull;
        const int count = 4 + int(d.random() % 197);
        for (int i = 0; i < count; ++i) {
            Vector3d p = d.direction() * std::cbrt(d.draw(0, 1));
            if (form == 1 && i % 2 && !hull.points.empty()) p = hull.points[d.random() % hull.points.size()];
            if (form == 2) p.z() = i % 2 ? 0.5 : std::round(2 * p.z()) / 2;
            if (form == 3) p.x() *= 1e-6, p.y() *= 1e-3;
            hull.points.push_back(p + Vector3d::Constant(far));
        }
        if (form < 3)
            hull.points.push_back(Vector3d::Constant(far) + Vector3d(0, 0, 1)),
                hull.points.push_back(-Vector3d::UnitZ());
        for (const Vector3d& axis : {Vector3d(0.1, 0, 0), Vector3d(0, 0.1, 0)})
            hull.points.push_back(hull.points.front() + (form == 3 ? 1e-6 : 1) * axis);
        Solid a{Shape(hull)}, b(d.shape(2, 1));
        const HullFaces& faces = a.model.hull_faces();
        const Mesh& surface = *a.model.surface_mesh();
        for (const HullFaces::Face& f : faces.faces()) { // every point is behind every face
            ASSERT_GE(f.count, 3u);
            const Vector3d from = surface.vertices[faces.corners(f)[0]];
            for (const Vector3d& v : surface.vertices) ASSERT_LE(f.normal.dot(v - from), 1e-8 * (1 + far)) << trial;
        }
        const Isometry3d pose = random_pose(d.random(), 0.3);
        Isometry3d there = pose;
        there.translation() += pose.linear() * Vector3d::Constant(far);
        const LeastTranslation found = least(a.model, pose, b.model, there);
        ASSERT_TRUE(found.beyond || found.lower <= found.upper) << trial;
        ASSERT_TRUE(std::isfinite(found.upper)) << trial;
        ++shapes;
    }
    EXPECT_EQ(shapes, 400u);
}

/// The separating axes of a triangle and a box against an expanding polytope. Also slivers, and edges along the box.
TEST(LeastTranslation, OfATriangleAndABoxIsThatOfThePolytope)
{
    Drawing d{std::mt19937_64(17)};
    std::size_t overlap = 0, with_points = 0;
    for (int trial = 0; trial < 20'000; ++trial) {
        Solid box{Shape(Box{{d.draw(0.1, 1), d.draw(0.1, 1), d.draw(0.1, 1)}})};
        const auto corner = [&] {
            const double z = d.draw(-1.5, 1.5), y = d.draw(-1.5, 1.5), x = d.draw(-1.5, 1.5);
            return Vector3d(x, y, z); // compilers evaluate arguments in any order
        };
        TrianglePoints triangle{corner(), corner(), corner()};
        if (trial % 4 == 1) triangle[2] = triangle[1] + 1e-6 * corner();
        if (trial % 4 == 2) triangle[1].x() = triangle[0].x(), triangle[1].y() = triangle[0].y();
        const Isometry3d pose = trial % 4 == 2 ? Isometry3d::Identity() : random_pose(d.random(), 0.5);
        const PlacedPair placed(Isometry3d::Identity(), pose);
        const Convex flat = convex_of(triangle);
        const ConvexDifference cores(flat, box.model.convex(), placed.b_to_a, placed.slack);
        const LeastTranslation found = least_translation(cores, 1e9);
        if (found.upper < 0) continue;
        ++overlap;
        const LeastTranslation other = deepest_translation(cores);
        const double tolerance = trial % 4 == 1 ? 1e-7 : trial % 4 == 2 ? 1e-10 : 1e-11; // slivers, edges along the box
        ASSERT_LE(found.lower, found.upper) << trial;
        EXPECT_LE(found.lower, other.upper + 1e-13) << trial;
        EXPECT_LE(other.lower, found.upper + 1e-13) << trial;
        EXPECT_LE(found.upper, 1.01 * other.upper + tolerance) << trial;
        EXPECT_GE(found.lower, other.upper - 0.01 * other.upper - tolerance) << trial;
        EXPECT_NEAR(-found.normal.dot(cores.support(-found.normal).w), found.upper, tolerance) << trial;
        if (!found.has_points) continue;
        ++with_points;
        const double depth = found.normal.dot(found.on_a - found.on_b);
        EXPECT_LE(depth, found.upper + 1e-12) << trial;
        double off = trial % 4 == 1 ? 1e9 : (nearest_on(triangle, found.on_a).at - found.on_a).norm();
        for (int k = 0; k < 3 && trial % 4 == 1; ++k) { // a sliver's edges are closer to it than its width
            const Vector3d edge = triangle[(k + 1) % 3] - triangle[k], way = found.on_a - triangle[k];
            const double along = std::clamp(way.dot(edge) / edge.squaredNorm(), 0.0, 1.0);
            off = std::min(off, (way - along * edge).norm());
        }
        EXPECT_LE(off, trial % 4 == 1 ? 3e-6 : 1e-12) << trial;
        EXPECT_LE(box.model.convex().depth(pose.inverse() * found.on_b), 1e-12) << trial;
    }
    EXPECT_GT(overlap, 5000u);
    EXPECT_GT(with_points, 1000u);
}

/// The difference of a triangle and a point is flat: no polytope has a volume.
TEST(LeastTranslation, OfATriangleAndABallThatAllButTouchIsTheirGap)
{
    Drawing d{std::mt19937_64(11)};
    const Convex ball = convex_of(Shape(Sphere{0.125}));
    for (int trial = 0; trial < 500; ++trial) {
        const Isometry3d pose = random_pose(d.random(), 1);
        const double gap = std::ldexp(1.0, -20 - trial % 24), aside = trial % 2 ? 2.5 : 0;
        const TrianglePoints triangle{pose * Vector3d(-3, -2, 0), pose * Vector3d(3, -2, 0), pose * Vector3d(0, 4, 0)};
        const Convex flat = convex_of(triangle);
        const Isometry3d at_ball(Eigen::Translation3d(pose * Vector3d(0, -aside, 0.125 + gap)));
        const RelativePose b_to_a(Isometry3d::Identity(), at_ball);
        const LeastTranslation found = least_translation(ConvexDifference(flat, ball, b_to_a, 0), 1);
        const double apart = std::hypot(std::max(aside - 2, 0.0), 0.125 + gap) - 0.125;
        EXPECT_LE(found.lower, found.upper) << trial;
        EXPECT_NEAR(found.upper, -apart, 2e-13) << trial;
        EXPECT_NEAR(found.lower, -apart, 2e-13) << trial;
    }
}

/// Many points of the difference are in one plane, or nearly, where faces of the polytope could fold over.
TEST(LeastTranslation, FindsTheFaceOfACylinderThatIsAlmostAlignedWithABox)
{
    Solid box(Box{{0.5, 0.75, 0.875}}), cylinder(Cylinder{0.875, 0.875});
    Isometry3d of_box = Isometry3d::Identity(), pose = Isometry3d::Identity();
    of_box.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    pose.linear() << 1, 1.1303263906273207e-12, 6.9926565569841747e-13, //
        6.9926565569841747e-13, -8.0980086852590902e-13, -1,            //
        -1.1303263906273207e-12, 1, -8.0980086852590902e-13;
    pose.translation() << -0.39381430704324893, 0.34793968463285269, -0.23010757242109098;
    const LeastTranslation found = least(box.model, of_box, cylinder.model, pose);
    EXPECT_NEAR(found.upper, 0.96456031536801523, 1e-9);
    EXPECT_NEAR(found.lower, 0.96456031536801523, 1e-6);
}

/// Their gap is below the roundings of the cone's size. A polytope knows less of it than the distance.
TEST(LeastTranslation, OfANeedleBesideALargeConeIsTheirGap)
{
    const double radius = 6.2080879983590727e-07;
    Solid needle(Capsule{radius, 0.085649535530358825}), cone(Cone{11190.563783340398, 11190.563783340398});
    Isometry3d of_needle = Isometry3d::Identity(), of_cone = Isometry3d::Identity();
    of_needle.linear() << 0, 1, 0, 1, 0, 0, 0, 0, -1;
    of_cone.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    of_cone.translation() << 0, -5595.2818921091775, 11190.606608547141;
    const LeastTranslation found = least(needle.model, of_needle, cone.model, of_cone);
    EXPECT_LE(found.lower, 0);
    EXPECT_LE(found.upper, 0.01 * radius);
}

} // namespace
} // namespace oncollide::least_translation_test
