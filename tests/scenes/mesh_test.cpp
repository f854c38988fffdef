#include <oncollide/scenes/model/mesh.hpp>

#include <limits>

#include <gtest/gtest.h>

#include "test_files.hpp"
#include <oncollide/samples/generators.hpp>

namespace oncollide {
namespace {

using Eigen::Vector3d;
using test::expect_error;

std::size_t zero_areas(Vector3d a, Vector3d b, Vector3d c)
{
    return make_mesh("one", {a, b, c}, {{0, 1, 2}}).zero_area;
}

TEST(Mesh, TellsTheFirstIndexThatIsOutOfRange)
{
    expect_error(
        ErrorKind::bad_data,
        [] {
            make_mesh("a.obj", std::vector<Vector3d>(3, Vector3d::Zero()), {{0, 1, 2}, {0, 3, 9}});
        },
        "a.obj: triangle 1 uses vertex 3, but the mesh has 3 vertices");
}

TEST(Mesh, RefusesNoTriangles)
{
    expect_error(
        ErrorKind::bad_data,
        [] {
            make_mesh("a.obj", {{0, 0, 0}}, {});
        },
        "a.obj: ", "no triangle");
}

TEST(Mesh, RefusesVerticesThatAreNotFiniteOrTooFar)
{
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    for (const double bad : {nan, inf, -inf, 1.1e15, -1.1e15})
        for (int axis = 0; axis < 3; ++axis) {
            std::vector<Vector3d> vertices(4, Vector3d::Zero());
            vertices[3][axis] = bad; // unused vertices count, too
            expect_error(
                ErrorKind::bad_data,
                [&] {
                    make_mesh("m", vertices, {{0, 1, 2}});
                },
                "m: vertex 3 ");
        }
}

TEST(Mesh, BoundsCoverUsedVerticesOnly)
{
    const Mesh mesh = make_mesh("m", {{9, 9, 9}, {0, 0, 0}, {1, 2, 0}, {0, 0, 3}}, {{1, 2, 3}});
    EXPECT_EQ(mesh.bounds.min, Vector3d(0, 0, 0));
    EXPECT_EQ(mesh.bounds.max, Vector3d(1, 2, 3));
    EXPECT_EQ(mesh.vertices.size(), 4u);
}

TEST(Mesh, CountsTrianglesWithoutAreaExactly)
{
    EXPECT_EQ(zero_areas({1, 2, 3}, {1, 2, 3}, {4, 5, 6}), 1u);
    EXPECT_EQ(zero_areas({0, 0, 0}, {0, 0, 0}, {0, 0, 0}), 1u);
    EXPECT_EQ(zero_areas({1, 1, 1}, {2, 2, 2}, {7, 7, 7}), 1u);
    EXPECT_EQ(make_mesh("m", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 1}}).zero_area, 1u);
    // Collinear as decimals, but not as doubles; and the reverse, hidden by cancellation.
    EXPECT_EQ(zero_areas({0.1, 0.1, 0}, {0.2, 0.2, 0}, {0.3, 0.3, 0}), 1u);
    EXPECT_EQ(zero_areas({0.1, 0.3, 0}, {0.2, 0.6, 0}, {0.3, 0.9, 0}), 0u) << "0.3 is not three times 0.1";
    const double next = std::nextafter(3.0, 4.0);
    EXPECT_EQ(zero_areas({1e6 + 1, 1e6 + 1, 0}, {1e6 + 2, 1e6 + 2, 0}, {1e6 + 3, std::nextafter(1e6 + 3, 2e6), 0}), 0u);
    EXPECT_EQ(zero_areas({1e6 + 1, 1e6 + 1, 5}, {1e6 + 2, 1e6 + 2, 5}, {1e6 + 3, 1e6 + 3, 5}), 1u);
    EXPECT_EQ(zero_areas({1, 1, 1}, {2, 2, 2}, {3, 3, next}), 0u);
    // Areas that underflow a double.
    EXPECT_EQ(zero_areas({0, 0, 0}, {1e-200, 0, 0}, {0, 1e-200, 0}), 0u);
    EXPECT_EQ(zero_areas({1e-200, 2e-200, 0}, {2e-200, 4e-200, 0}, {4e-200, 8e-200, 0}), 1u);
}

TEST(Mesh, MovesThenScales)
{
    const Mesh mesh = transformed("m", make_box_mesh({1, 2, 3}), 0.5, {1, 2, 3});
    EXPECT_EQ(mesh.bounds.min, Vector3d(-1, -2, -3));
    EXPECT_EQ(mesh.bounds.max, Vector3d(0, 0, 0));
    EXPECT_TRUE(is_closed(mesh));
}

TEST(Mesh, RefusesATransformThatOverflows)
{
    expect_error(
        ErrorKind::bad_data,
        [] {
            transformed("m", make_box_mesh({1, 1, 1}), 1e300, {0, 0, 0});
        },
        "m: vertex 0");
    expect_error(
        ErrorKind::bad_data,
        [] {
            transformed("m", make_box_mesh({1, 1, 1}), std::numeric_limits<double>::quiet_NaN(), {0, 0, 0});
        },
        "m: vertex 0");
}

TEST(Mesh, ABoxIsClosedAndStaysSoAsSoup)
{
    const Mesh box = make_box_mesh({1, 1, 1});
    ASSERT_TRUE(is_closed(box));
    Mesh soup = box;
    soup.vertices.clear();
    for (Triangle& t : soup.triangles)
        for (std::uint32_t& v : t) {
            soup.vertices.push_back(box.vertices[v]);
            v = static_cast<std::uint32_t>(soup.vertices.size() - 1);
        }
    EXPECT_TRUE(is_closed(soup));
    soup.vertices[0].x() = std::nextafter(soup.vertices[0].x(), 10.0);
    EXPECT_FALSE(is_closed(soup));
}

TEST(Mesh, ZerosOfBothSignsAreOnePosition)
{
    Mesh mesh = make_mesh("m", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-0.0, -0.0, 1}},
                          {{0, 2, 1}, {0, 1, 3}, {1, 2, 4}, {2, 0, 3}});
    EXPECT_TRUE(is_closed(mesh));
}

TEST(Mesh, AHoleAFlipOrAFinOpensIt)
{
    const Mesh box = make_box_mesh({1, 1, 1});
    Mesh hole = box, flip = box, fin = box, twice = box;
    hole.triangles.pop_back();
    EXPECT_FALSE(is_closed(hole));
    std::swap(flip.triangles[3][0], flip.triangles[3][1]);
    EXPECT_FALSE(is_closed(flip));
    fin.vertices.push_back({5, 5, 5});
    fin.triangles.push_back({0, 1, 8});
    EXPECT_FALSE(is_closed(fin));
    fin.triangles.push_back({1, 0, 8});
    EXPECT_TRUE(is_closed(fin)) << "a fin of two sides";
    twice.triangles.insert(twice.triangles.end(), box.triangles.begin(), box.triangles.end());
    EXPECT_TRUE(is_closed(twice)) << "four triangles on every edge, two in each direction";
}

TEST(Mesh, TrianglesWithoutAreaDoNotOpenIt)
{
    Mesh box = make_box_mesh({1, 1, 1});
    box.triangles.push_back({0, 0, 1}), box.triangles.push_back({2, 2, 2});
    EXPECT_TRUE(is_closed(box));
    EXPECT_FALSE(is_closed(make_mesh("m", {{0, 0, 0}, {1, 1, 1}}, {{0, 0, 1}}))) << "nothing has an area";
}

} // namespace
} // namespace oncollide
