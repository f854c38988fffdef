#include <oncollide/base/numbers/random.hpp>
#include <oncollide/scenes/model/shape.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "test_files.hpp"
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/model/convex_hull.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide::shape_test {
namespace {

using Eigen::Vector3d;
using test::expect_error;

Vector3d random_vector(std::uint64_t index)
{
    return {2 * u01(5, index, 0) - 1, 2 * u01(5, index, 1) - 1, 2 * u01(5, index, 2) - 1};
}

/// The support function of the shape for the unit vector d.
double support(const Shape& shape, const Vector3d& d)
{
    if (const auto* s = std::get_if<Sphere>(&shape)) return s->radius;
    if (const auto* b = std::get_if<Box>(&shape)) return d.cwiseAbs().dot(b->half);
    if (const auto* c = std::get_if<Capsule>(&shape)) return c->radius + 0.5 * c->length * std::abs(d.z());
    if (const auto* c = std::get_if<Cylinder>(&shape))
        return c->radius * std::hypot(d.x(), d.y()) + 0.5 * c->length * std::abs(d.z());
    if (const auto* e = std::get_if<Ellipsoid>(&shape)) return e->semi_axes.cwiseProduct(d).norm();
    if (const auto* c = std::get_if<Cone>(&shape))
        return std::max(0.5 * c->length * d.z(), c->radius * std::hypot(d.x(), d.y()) - 0.5 * c->length * d.z());
    double most = -1e300;
    for (const Vector3d& p : std::get<ConvexHull>(shape).points) most = std::max(most, d.dot(p));
    return most;
}

/// Distance of p from the solid; for a hull a lower bound (0), its vertices are tested separately.
double distance(const Shape& shape, const Vector3d& p)
{
    const auto outside = [](double a, double b) { return std::hypot(std::max(a, 0.0), std::max(b, 0.0)); };
    if (const auto* s = std::get_if<Sphere>(&shape)) return std::max(0.0, p.norm() - s->radius);
    if (const auto* b = std::get_if<Box>(&shape)) return (p.cwiseAbs() - b->half).cwiseMax(0.0).norm();
    if (const auto* c = std::get_if<Capsule>(&shape))
        return std::max(0.0,
                        Vector3d(p.x(), p.y(), std::max(0.0, std::abs(p.z()) - 0.5 * c->length)).norm() - c->radius);
    if (const auto* c = std::get_if<Cylinder>(&shape))
        return outside(std::hypot(p.x(), p.y()) - c->radius, std::abs(p.z()) - 0.5 * c->length);
    if (const auto* c = std::get_if<Cone>(&shape)) { // from the triangle of its outline
        const double across = std::hypot(p.x(), p.y()), z = p.z(), half = 0.5 * c->length;
        const double t = ((c->radius - across) * c->radius + (z + half) * c->length) /
                         (c->radius * c->radius + c->length * c->length);
        const bool inside = z >= -half && across * c->length <= c->radius * (half - z);
        if (inside) return 0;
        if (z < -half && across <= c->radius) return -half - z;
        const double s = std::clamp(t, 0.0, 1.0);
        return std::hypot(across - c->radius * (1 - s), z + half - c->length * s);
    }
    return 0;
}

double size_of(const Shape& shape)
{
    return bounds_of(shape).diagonal() + bounds_of(shape).centre().norm();
}

ConvexHull random_hull(std::size_t count, double scale, double offset)
{
    ConvexHull hull;
    for (std::size_t i = 0; i < count; ++i)
        hull.points.push_back(scale * random_vector(i) + Vector3d::Constant(offset));
    return hull;
}

std::vector<Shape> shapes()
{
    std::vector<Shape> all = {Sphere{1},
                              Sphere{1e-6},
                              Sphere{1e6},
                              Box{{1, 2, 3}},
                              Box{{1e-3, 1, 1e3}},
                              Capsule{1, 2},
                              Capsule{0.1, 100},
                              Capsule{5, 0.01},
                              Capsule{1, 0},
                              Capsule{1e-3, 1e6},
                              Cylinder{1, 2},
                              Cylinder{0.01, 50},
                              Ellipsoid{{1, 2, 3}},
                              Ellipsoid{{1e-3, 1, 1e3}},
                              Cone{1, 2},
                              Cone{1e-3, 50},
                              Cone{50, 1e-2},
                              Cylinder{50, 0.01},
                              random_hull(4, 1, 0),
                              random_hull(20, 1, 0),
                              random_hull(500, 1e-6, 0),
                              random_hull(500, 1, 1e6),
                              random_hull(500, 1e6, 0)};
    ConvexHull cube, grid, slab, ball;
    for (int i = 0; i < 8; ++i) cube.points.push_back({i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0});
    for (int i = 0; i < 1000; ++i) grid.points.push_back(0.1 * Vector3d(i % 10, i / 10 % 10, i / 100));
    const Eigen::Quaterniond turn = Eigen::Quaterniond(1, 2, 3, 4).normalized();
    for (Vector3d& p : grid.points) p = turn * p; // many points near six planes, none exactly on them
    for (std::uint64_t i = 0; i < 300; ++i) slab.points.push_back(random_vector(i).cwiseProduct(Vector3d(1, 1, 1e-5)));
    ball.points = make_sphere_mesh(1, 2000).vertices;
    for (const ConvexHull& hull : {cube, grid, slab, ball}) all.emplace_back(hull);
    return all;
}

TEST(Shape, EnclosuresAreClosedConvexAndOutward)
{
    for (const Shape& shape : shapes()) {
        const Mesh mesh = bounding_mesh_of(shape).mesh;
        SCOPED_TRACE(testing::Message() << "kind " << shape.index() << ", size " << size_of(shape));
        EXPECT_TRUE(is_closed(mesh));
        const double rounding = 1e-9 * mesh.bounds.diagonal() + 1e-15 * size_of(shape);
        for (const Triangle& t : mesh.triangles) {
            const Vector3d& a = mesh.vertices[t[0]];
            const Vector3d u = mesh.vertices[t[1]] - a, v = mesh.vertices[t[2]] - a, n = u.cross(v);
            if (n.norm() < 1e-6 * u.norm() * v.norm()) continue; // its plane is not well defined
            const Vector3d normal = n.normalized();
            for (const Vector3d& p : mesh.vertices) ASSERT_LE(normal.dot(p - a), rounding);
        }
    }
}

TEST(Shape, NoFacetOfAnEnclosureCutsIntoTheShape)
{
    for (const Shape& shape : shapes()) {
        SCOPED_TRACE(testing::Message() << "kind " << shape.index() << ", size " << size_of(shape));
        const Mesh mesh = bounding_mesh_of(shape).mesh;
        Vector3d inner = Vector3d::Zero();
        for (const Vector3d& p : mesh.vertices) inner += p / static_cast<double>(mesh.vertices.size());
        for (const Triangle& t : mesh.triangles) {
            const Vector3d& a = mesh.vertices[t[0]];
            const Vector3d u = mesh.vertices[t[1]] - a, v = mesh.vertices[t[2]] - a, n = u.cross(v);
            const Vector3d normal = n.normalized();
            // The rounding error of this check: the normal of a thin facet is less accurate.
            const double rounding = 1e-15 * size_of(shape) * (1 + u.norm() * v.norm() / n.norm());
            ASSERT_LE(support(shape, normal), normal.dot(a) + rounding);
            ASSERT_GT(normal.dot(a - inner), 0);
        }
    }
}

// In 113-bit arithmetic, without any tolerance: hulls are expanded by amounts as small as rounding.
TEST(Shape, HullPointsLieStrictlyInsideTheirEnclosures)
{
    __extension__ typedef __float128 Quad;
    const auto height = [](const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& p) {
        Quad u[3], v[3], w[3];
        for (int k = 0; k < 3; ++k) u[k] = Quad(b[k]) - a[k], v[k] = Quad(c[k]) - a[k], w[k] = Quad(p[k]) - a[k];
        return w[0] * (u[1] * v[2] - u[2] * v[1]) + w[1] * (u[2] * v[0] - u[0] * v[2]) +
               w[2] * (u[0] * v[1] - u[1] * v[0]);
    };
    for (const Shape& shape : shapes()) {
        if (!std::holds_alternative<ConvexHull>(shape)) continue;
        SCOPED_TRACE(testing::Message() << "size " << size_of(shape));
        const Mesh mesh = bounding_mesh_of(shape).mesh;
        for (const Triangle& t : mesh.triangles) {
            const Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
            if ((b - a).cross(c - a).norm() < 1e-6 * (b - a).norm() * (c - a).norm()) continue; // tilted by rounding
            for (const Vector3d& p : std::get<ConvexHull>(shape).points) ASSERT_TRUE(height(a, b, c, p) < 0);
        }
    }
}

TEST(Shape, NoPointOfAnEnclosureIsFartherThanItsCoveringError)
{
    for (const Shape& shape : shapes()) {
        SCOPED_TRACE(testing::Message() << "kind " << shape.index() << ", size " << size_of(shape));
        const BoundingMesh enclosure = bounding_mesh_of(shape);
        const double rounding = 1e-15 * size_of(shape);
        for (const Triangle& t : enclosure.mesh.triangles)
            for (int i = 0; i <= 4; ++i)
                for (int j = 0; i + j <= 4; ++j) {
                    const Vector3d p = 0.25 * (i * enclosure.mesh.vertices[t[0]] + j * enclosure.mesh.vertices[t[1]] +
                                               (4 - i - j) * enclosure.mesh.vertices[t[2]]);
                    ASSERT_LE(distance(shape, p), enclosure.covering_error + rounding);
                }
        // The reverse: the supports differ by at most the error.
        for (std::uint64_t i = 0; i < 500; ++i) {
            const Vector3d d = random_vector(i).normalized();
            double reach = -1e300;
            for (const Vector3d& p : enclosure.mesh.vertices) reach = std::max(reach, d.dot(p));
            ASSERT_LE(reach, support(shape, d) + enclosure.covering_error + rounding);
            ASSERT_GE(reach, support(shape, d) - rounding);
        }
    }
}

TEST(Shape, CurvedShapesErrByAboutHalfAPercentOfTheRadius)
{
    for (const Shape& shape : std::vector<Shape>{Sphere{2}, Capsule{2, 5}, Cylinder{2, 5}}) {
        const BoundingMesh enclosure = bounding_mesh_of(shape);
        EXPECT_GT(enclosure.covering_error, 0.002 * 2);
        EXPECT_LT(enclosure.covering_error, 0.0055 * 2);
        EXPECT_LE(enclosure.mesh.triangles.size(), 1700u);
    }
}

TEST(Shape, BoxesAreExactAndHullsNearlySo)
{
    EXPECT_EQ(bounding_mesh_of(Box{{1, 2, 3}}).covering_error, 0);
    EXPECT_LT(bounding_mesh_of(random_hull(200, 1, 0)).covering_error, 1e-11);
    for (const Shape& shape : shapes())
        if (std::holds_alternative<ConvexHull>(shape)) {
            EXPECT_LT(bounding_mesh_of(shape).covering_error, 1e-7 * bounds_of(shape).diagonal() + 1e-8);
        }
}

TEST(Shape, BoundsAreTight)
{
    for (const Shape& shape : shapes())
        for (int axis = 0; axis < 3; ++axis) {
            const Aabb box = bounds_of(shape);
            EXPECT_EQ(box.max[axis], support(shape, Vector3d::Unit(axis)));
            EXPECT_EQ(-box.min[axis], support(shape, -Vector3d::Unit(axis)));
        }
}

TEST(Shape, ImpossibleDimensionsAreNamed)
{
    const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
    const auto refused = [](const Shape& shape, const char* part) {
        expect_error(
            ErrorKind::bad_data, [&] { check_shape("lamp", shape); }, "lamp: ", part);
    };
    refused(Sphere{0}, "radius is 0");
    refused(Sphere{nan}, "radius is nan");
    refused(Sphere{inf}, "radius is inf");
    refused(Sphere{-1}, "radius is -1");
    refused(Box{{1, -2, 3}}, "half-extent y is -2");
    refused(Box{{1, 2, nan}}, "half-extent z is nan");
    refused(Capsule{0, 1}, "radius is 0");
    refused(Capsule{1, -0.5}, "length is -0.5");
    refused(Cylinder{1, 0}, "length is 0");
    refused(Ellipsoid{{1, 0, 3}}, "semi-axis y is 0");
    refused(Ellipsoid{{-1, 1, 3}}, "semi-axis x is -1");
    refused(Ellipsoid{{1, 1, inf}}, "semi-axis z is inf");
    refused(Cone{0, 1}, "radius is 0");
    refused(Cone{1, nan}, "length is nan");
    refused(Sphere{1e-310}, "scale the scene up");
    refused(Box{{1, 1, 1e-100}}, "half-extent z is 1e-100");
    refused(Cone{1, 1e-310}, "scale the scene up");
    refused(ConvexHull{{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}}, "lie in a plane");
    refused(ConvexHull{{{0, 0, 0}, {1, 2, 3}, {2, 4, 6}, {3, 6, 9}}}, "lie in a plane");
    refused(ConvexHull{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, "3 points");
    refused(ConvexHull{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}}, "lie in a plane");
    refused(ConvexHull{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, nan}}}, "point 3");
    refused(ConvexHull{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1e16, 1}}}, "point 3");
    for (const Shape& shape : shapes()) EXPECT_NO_THROW(check_shape("good", shape));
}

} // namespace
} // namespace oncollide::shape_test
