// Bullet's GImpact on meshes.
#pragma once
#include "peers/bullet_world.hpp"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

namespace oncollide::tools::bullet {

/// A mesh as one part of a GImpact shape.
class GImpactMesh {
public:
    explicit GImpactMesh(const Mesh& mesh)
        : mesh_(mesh), part(std::make_unique<btGImpactMeshShapePart>(mesh_.arrays(), 0))
    {
        part->setMargin(0);
        part->updateBound();
        part->lockChildShapes();
    }
    ~GImpactMesh() { part->unlockChildShapes(); }
    GImpactMesh(const GImpactMesh&) = delete;
    GImpactMesh& operator=(const GImpactMesh&) = delete;

    void set_vertices(std::span<const Eigen::Vector3d> positions)
    {
        mesh_.set_vertices(positions);
        part->postUpdate(), part->updateBound();
    }

private:
    BulletMesh mesh_;

public:
    std::unique_ptr<btGImpactMeshShapePart> part; ///< declared last: destroyed before the data it points to
};

/// The test of two triangles in GImpact, by its clip method.
inline bool gimpact_triangles_meet(const GImpactMesh& a, const GImpactMesh& b, const btTransform& pose_b,
                                   const GIM_PAIR& pair)
{
    btPrimitiveTriangle p, q;
    a.part->getPrimitiveTriangle(pair.m_index1, p), b.part->getPrimitiveTriangle(pair.m_index2, q);
    p.m_margin = q.m_margin = 0;
    q.applyTransform(pose_b);
    p.buildTriPlane(), q.buildTriPlane();
    GIM_TRIANGLE_CONTACT contact;
    return p.overlap_test_conservative(q) && p.find_triangle_collision_clip_method(q, contact);
}

} // namespace oncollide::tools::bullet
