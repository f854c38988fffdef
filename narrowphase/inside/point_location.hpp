#pragma once
#include <vector>

#include <oncollide/narrowphase/obb/traversal.hpp>

namespace oncollide {

/// Where a point lies. Inside: the mesh winds around it, in either direction; so a part inside another one is a cavity
/// when it is oriented the other way, and else changes nothing.
enum class PointLocation { outside, inside, surface };

/// Finds where points lie in closed meshes: exactly, however near the surface, for the mesh's coordinates as stored and
/// then moved by `into` in double, as the exact level moves them.
///
/// A ray from the point out of the mesh is walked through its tree as a triangle that is a segment; each triangle that
/// it crosses counts 1 or -1, by exact signs. A ray that only touches one (an edge, a corner) says nothing: the next is
/// tried.
///
/// One thread's working memory; others may walk the same trees meanwhile.
class PointLocator {
public:
    /// @param tree   of the mesh; null: all its triangles are tested
    /// @param into   moves the mesh into the point's frame
    /// Cost: about 5 microseconds for a mesh of 5,000 triangles; without a tree 50 ns a triangle.
    PointLocation place(const Eigen::Vector3d& point, const Mesh& mesh, ObbTree* tree, const RelativePose& into);

private:
    Traversal walk_;
    std::vector<TrianglePair> hits_;
};

} // namespace oncollide
