#include <oncollide/narrowphase/pairs/manifolds/points/faces_ahead.hpp>

#include <cmath>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>

namespace oncollide::faces_ahead_test {
namespace {

using Eigen::Vector3d;

/// A unit square at a height, seen from above, as two triangles.
std::vector<NumberedTriangle> square_at(double height, std::uint32_t number = 0)
{
    const Vector3d a(0, 0, height), b(1, 0, height), c(1, 1, height), d(0, 1, height);
    return {{number, {a, b, c}}, {number + 1, {a, c, d}}};
}

TEST(FacesAhead, MeasureTheDepthBelowAFace)
{
    FacesAhead ahead;
    ahead.set(square_at(2), Vector3d::UnitZ());
    double depth, beside_by;
    const auto* face = ahead.nearest({0.75, 0.25, 0.5}, depth, beside_by);
    ASSERT_NE(face, nullptr);
    EXPECT_EQ(face->triangle, 0u);
    EXPECT_EQ(depth, 1.5);
    face = ahead.nearest({0.25, 0.75, 3}, depth, beside_by);
    ASSERT_NE(face, nullptr);
    EXPECT_EQ(face->triangle, 1u);
    EXPECT_EQ(depth, -1) << "in front of the face";
    EXPECT_EQ(ahead.nearest({1.25, 0.5, 0}, depth, beside_by), nullptr);
    EXPECT_EQ(depth, std::numeric_limits<double>::infinity());
}

TEST(FacesAhead, TakeTheNearestOfFacesAboveEachOther)
{
    std::vector<NumberedTriangle> faces = square_at(5, 10), near = square_at(1, 20);
    faces.insert(faces.end(), near.begin(), near.end());
    FacesAhead ahead;
    ahead.set(faces, Vector3d::UnitZ());
    double depth, beside_by;
    EXPECT_EQ(ahead.nearest({0.75, 0.25, 0}, depth, beside_by)->triangle, 20u);
    EXPECT_EQ(depth, 1);
    EXPECT_EQ(ahead.nearest({0.75, 0.25, 4}, depth, beside_by)->triangle, 10u);
    EXPECT_EQ(depth, 1);
}

TEST(FacesAhead, LeaveOutFacesThatTheLinesEnterOrGraze)
{
    const double slope = 1e-8; // of a wall, nearly along z
    const NumberedTriangle wall{1, {Vector3d(0, 0, 0), Vector3d(slope, 0, 1), Vector3d(0, 1, 0)}};
    std::vector<NumberedTriangle> faces{wall, {2, {Vector3d(0, 0, 0), Vector3d(0, 1, 0), Vector3d(1, 0, 0)}}};
    FacesAhead ahead;
    ahead.set(faces, Vector3d::UnitZ());
    EXPECT_TRUE(ahead.faces().empty()) << "one grazes, one looks down";
    ahead.set(faces, -Vector3d::UnitZ());
    ASSERT_EQ(ahead.faces().size(), 1u);
    EXPECT_EQ(ahead.faces()[0].triangle, 2u);
}

TEST(FacesAhead, HaveNoGapsBetweenNeighbours)
{
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        const auto number = [&](std::uint64_t k) { return 2 * u01(seed, k, 0) - 1; };
        // Four triangles around a corner, over a square, at heights.
        const Vector3d apex(0.5 * number(0), 0.5 * number(1), number(2));
        std::array<Vector3d, 4> rim{Vector3d(-1, -1, number(3)), Vector3d(1, -1, number(4)), Vector3d(1, 1, number(5)),
                                    Vector3d(-1, 1, number(6))};
        std::vector<NumberedTriangle> fan;
        for (std::uint32_t k = 0; k < 4; ++k) fan.push_back({k, {apex, rim[k], rim[(k + 1) % 4]}});
        FacesAhead ahead;
        ahead.set(fan, Vector3d::UnitZ());
        ASSERT_EQ(ahead.faces().size(), 4u);
        for (std::uint64_t k = 0; k < 4; ++k) {
            const double share = u01(seed, k, 1);
            const Vector3d on_edge = apex + share * (rim[k] - apex);
            double depth, beside_by;
            ASSERT_NE(ahead.nearest(on_edge - 0.25 * Vector3d::UnitZ(), depth, beside_by), nullptr) << seed;
            EXPECT_NEAR(depth, 0.25, 1e-12) << seed;
        }
    }
}

TEST(FacesAhead, BoundTheErrorOfTheDepthByTheSlope)
{
    // A face at 60 degrees: a step of 1 across it changes the depth by 2.
    const double tall = std::sqrt(3.0);
    FacesAhead ahead;
    ahead.set({{{0, {Vector3d(0, 0, 0), Vector3d(1, 0, tall), Vector3d(0, 1, 0)}}}}, Vector3d::UnitZ());
    ASSERT_EQ(ahead.faces().size(), 1u);
    EXPECT_NEAR(ahead.faces()[0].error, 2, 1e-12);
    double depth, aside, beside_by;
    ASSERT_TRUE(ahead.nearest({0.25, 0.25, 0}, depth, beside_by) && ahead.nearest({0.26, 0.25, 0}, aside, beside_by));
    EXPECT_NEAR(aside - depth, 0.01 * tall, 1e-12);
    EXPECT_EQ(beside_by, 0);
    ASSERT_TRUE(ahead.nearest({0.25, -5e-10, 0}, depth, beside_by)) << "nearly on the edge";
    EXPECT_GE(beside_by, 5e-10);
    EXPECT_LT(beside_by, 1e-8);
}

} // namespace
} // namespace oncollide::faces_ahead_test
