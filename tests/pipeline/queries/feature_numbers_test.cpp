// The numbers in a feature's bits: the vertices, edges and triangles of the mesh that was added.
#include <algorithm>

#include <gtest/gtest.h>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide {
namespace {

using Eigen::Vector3d;

/// The distance of a point from the vertex, edge or triangle that a feature names.
double distance_from(const Mesh& mesh, FeatureBits feature, const Vector3d& p)
{
    const auto& v = mesh.vertices;
    if (kind_of(feature) == FeatureKind::vertex) return (v[number_of(feature)] - p).norm();
    if (kind_of(feature) == FeatureKind::edge) {
        const auto [from, to] = edge_vertices(feature);
        const Vector3d d = v[to] - v[from];
        return (v[from] + std::clamp(d.dot(p - v[from]) / d.squaredNorm(), 0.0, 1.0) * d - p).norm();
    }
    const Triangle& t = mesh.triangles[number_of(feature)];
    return std::abs((v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).normalized().dot(p - v[t[0]]));
}

TEST(FeatureNumbers, NameTheVerticesOfNearFeatures)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.2, 2000), ball = make_sphere_mesh(0.5, 2048);
    World world;
    const BodyId a = world.bodies().add({.model = world.models().add(knot)});
    const BodyId b = world.bodies().add({.model = world.models().add(ball)});
    const auto found = world.pairs().near_features(a, b, 0.2);
    std::array<int, 4> kinds{};
    for (const NearFeatures& f : found) {
        ++kinds[static_cast<int>(kind_of(f.a))];
        EXPECT_LT(distance_from(knot, f.a, f.point_a), 1e-12);
        EXPECT_LT(distance_from(ball, f.b, f.point_b), 1e-12);
        if (kind_of(f.a) == FeatureKind::edge) {
            const auto [from, to] = edge_vertices(f.a);
            EXPECT_LT(from, to);
        }
    }
    EXPECT_EQ(kinds[0], 0);
    for (int kind = 1; kind < 4; ++kind) EXPECT_GT(kinds[kind], 10);
}

TEST(FeatureNumbers, NameTheCornersOfBoxesInManifolds)
{
    World world;
    const ModelId box = world.models().add(Shape(Box{{1, 1, 1}}));
    Eigen::Isometry3d turned(Eigen::Translation3d(0.2, 0.1, 1.99));
    turned.rotate(Eigen::AngleAxisd(0.3, Vector3d::UnitZ()));
    const BodyId a = world.bodies().add({.model = box}), b = world.bodies().add({.model = box, .pose = turned});
    const Manifold found = world.pairs().manifold(a, b);
    int edges = 0;
    for (const ManifoldPoint& p : found.points) {
        if (kind_of(p.feature_a) != FeatureKind::edge) continue;
        ++edges;
        for (const std::uint32_t corner : edge_vertices(p.feature_a)) // bit 2 of a corner's number: it is at the top
            EXPECT_EQ(corner & 4, 4u);
    }
    EXPECT_GT(edges, 1);
}

} // namespace
} // namespace oncollide
