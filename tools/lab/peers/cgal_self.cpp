// A file of its own: CGAL's headers for polygon meshes take long to compile.
#include "peers/peers.hpp"

#include <iterator>
#include <optional>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>

namespace oncollide::tools {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

/// self_intersections() of the mesh with its edges linked. Needs a mesh whose edges have at most two triangles, in
/// opposite directions.
class CgalSelfPeer final : public SelfPeer {
public:
    explicit CgalSelfPeer(const Mesh& mesh)
    {
        std::vector<SurfaceMesh::Vertex_index> vertices;
        for (const Eigen::Vector3d& p : mesh.vertices) vertices.push_back(mesh_.add_vertex({p.x(), p.y(), p.z()}));
        for (const auto& [a, b, c] : mesh.triangles)
            if (mesh_.add_face(vertices[a], vertices[b], vertices[c]) == SurfaceMesh::null_face())
                throw Error(ErrorKind::bad_data, "CGAL: the mesh has an edge of three triangles, or of two in one "
                                                 "direction");
    }

    void pairs(std::vector<TrianglePair>& found) override
    {
        std::vector<std::pair<SurfaceMesh::Face_index, SurfaceMesh::Face_index>> faces;
        CGAL::Polygon_mesh_processing::self_intersections(mesh_, std::back_inserter(faces));
        found.clear();
        for (const auto& [s, t] : faces)
            if (s != t) // a face with itself: it has no area, and CGAL does not compare it with others
                found.push_back({std::min<std::uint32_t>(s, t), std::max<std::uint32_t>(s, t)});
    }

private:
    SurfaceMesh mesh_;
};

} // namespace

void add_cgal_self(Contenders& all)
{
    all.self.all.push_back({.name = "cgal",
                            .what = "CGAL Polygon_mesh_processing::self_intersections; exact predicates",
                            .make = maker<CgalSelfPeer>()});
}

} // namespace oncollide::tools
