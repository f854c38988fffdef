// The faces of hulls as polygons.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <oncollide/narrowphase/shapes/hull_faces.hpp>
#include <oncollide/scenes/model/box_corners.hpp>

namespace oncollide::hull_faces_test {
namespace {

using Eigen::Vector3d;

Mesh box(const Vector3d& half)
{
    Mesh mesh;
    for (unsigned k = 0; k < 8; ++k) mesh.vertices.push_back(corner_of({-half, half}, k));
    mesh.triangles.assign(box_faces.begin(), box_faces.end());
    return mesh;
}

TEST(HullFaces, JoinsTheTrianglesOfABox)
{
    const HullFaces faces(box({1, 2, 3}));
    ASSERT_EQ(faces.faces().size(), 6u);
    for (const HullFaces::Face& f : faces.faces()) {
        EXPECT_EQ(f.count, 4u);
        EXPECT_EQ(f.off, 0);
        EXPECT_NEAR(f.sharp, std::numbers::sqrt2, 1e-12);
    }
    for (std::uint32_t v = 0; v < 8; ++v) EXPECT_EQ(faces.around(v).size(), 3u);
}

TEST(HullFaces, KnowsItsSharpestCorner)
{
    const double angle = 1e-7, far = std::tan(angle);
    Mesh needle; // a tetrahedron whose first face has the angle at its first corner
    needle.vertices = {{0, 0, 0}, {1, 0, 0}, {1, far, 0}, {0.5, 0.5 * far, 1}};
    needle.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    const HullFaces faces(needle);
    ASSERT_EQ(faces.faces().size(), 4u);
    const auto first = std::ranges::find(faces.faces(), 0u, &HullFaces::Face::triangle);
    EXPECT_NEAR(first->sharp * std::sin(angle / 2), 1, 1e-6);
}

} // namespace
} // namespace oncollide::hull_faces_test
