#include <gtest/gtest.h>

#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/model/mesh_topology.hpp>

namespace oncollide {
namespace {

TEST(OpenEdges, AreThoseThatKeepAMeshFromBeingClosed)
{
    const Mesh box = make_box_mesh({1, 1, 1});
    EXPECT_TRUE(open_edges(box).empty());
    Mesh hole = box;
    hole.triangles.pop_back();
    EXPECT_EQ(open_edges(hole).size(), 3u);
    Mesh flip = box;
    std::swap(flip.triangles[0][0], flip.triangles[0][1]);
    EXPECT_EQ(open_edges(flip).size(), 3u) << "two triangles traverse each edge in the same direction";
    Mesh fin = box;
    fin.vertices.push_back({5, 5, 5});
    fin.triangles.push_back({0, 1, static_cast<std::uint32_t>(fin.vertices.size() - 1)});
    EXPECT_EQ(open_edges(fin).size(), 3u) << "three triangles on one edge, and two edges with one";
    const Mesh lone = make_mesh("m", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 2, 2}}, {{2, 0, 1}, {3, 3, 0}});
    EXPECT_EQ(open_edges(lone), (std::vector<MeshEdge>{{0, 1}, {2, 0}, {1, 2}})) << "in the order of their vertices";
}

TEST(PartsOf, CountTrianglesThatShareAPosition)
{
    // Two quads, far from each other; the triangles of the second share no vertices.
    const Mesh mesh = make_mesh("m",
                                {{0, 0, 0},
                                 {1, 0, 0},
                                 {1, 1, 0},
                                 {0, 1, 0},
                                 {5, 0, 0},
                                 {6, 0, 0},
                                 {6, 1, 0}, //
                                 {5, 0, 0},
                                 {6, 1, 0},
                                 {5, 1, 0}},
                                {{4, 5, 6}, {0, 1, 2}, {7, 8, 9}, {0, 2, 3}});
    EXPECT_EQ(parts_of(mesh), (std::vector<std::uint32_t>{0, 1, 0, 1}));
}

} // namespace
} // namespace oncollide
