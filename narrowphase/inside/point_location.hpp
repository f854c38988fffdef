#pragma once
#include <vector>

#include <oncollide/narrowphase/walks/traversal.hpp>

namespace oncollide {

/// The location of a point. A point is inside if the mesh winds around it, in either direction. A part inside another
/// part is therefore a cavity if its orientation is opposite; otherwise it changes nothing.
enum class PointLocation { outside, inside, surface };

/// Locates points in closed meshes: exactly, however near the surface, for the mesh's coordinates as stored and then
/// moved by `into` in double, as the exact level moves them.
///
/// A ray from the point to the outside of the mesh is a triangle degenerated to a segment, and traverses the mesh's
/// tree. Each triangle that it crosses counts 1 or -1, by exact signs. A ray that touches an edge or a corner is not
/// used; another one is tried.
///
/// One thread's working memory; other threads may traverse the same trees meanwhile.
class PointLocator {
public:
    /// @param tree   the tree of the mesh; null: all its triangles are tested
    /// @param into   moves the mesh into the point's frame
    /// Cost: about 5 microseconds for a mesh of 5,000 triangles; without a tree 50 ns per triangle.
    PointLocation place(const Eigen::Vector3d& point, const Mesh& mesh, ObbTree* tree, const RelativePose& into);

private:
    Traversal walk_;
    std::vector<TrianglePair> hits_;
};

} // namespace oncollide
