// Code that all files about Bullet share.
#pragma once
#include "peers/peers.hpp"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <btBulletCollisionCommon.h>

namespace oncollide::tools {

void add_bullet_contacts(Contenders& all);
void add_bullet_deform(Contenders& all);
void add_bullet_physics(Contenders& all);

namespace bullet {

inline btVector3 vector_of(const Eigen::Vector3d& p)
{
    return {btScalar(p.x()), btScalar(p.y()), btScalar(p.z())};
}

inline btTransform transform_of(const Eigen::Isometry3d& pose)
{
    const Eigen::Matrix3d rows = pose.linear().transpose();
    const btVector3 x = vector_of(rows.col(0)), y = vector_of(rows.col(1)), z = vector_of(rows.col(2));
    const btMatrix3x3 turn(x.x(), x.y(), x.z(), y.x(), y.y(), y.z(), z.x(), z.y(), z.z());
    return btTransform(turn, vector_of(pose.translation()));
}

/// A mesh in Bullet's form and precision. Bullet's shapes keep pointers into it.
class BulletMesh {
public:
    explicit BulletMesh(const Mesh& mesh) : vertices_(3 * mesh.vertices.size())
    {
        set_vertices(mesh.vertices);
        for (const Triangle& t : mesh.triangles) indices_.insert(indices_.end(), t.begin(), t.end());
        arrays_ = std::make_unique<btTriangleIndexVertexArray>(int(mesh.triangles.size()), indices_.data(),
                                                               int(3 * sizeof(int)), int(mesh.vertices.size()),
                                                               vertices_.data(), int(3 * sizeof(btScalar)));
    }
    BulletMesh(const BulletMesh&) = delete;
    BulletMesh& operator=(const BulletMesh&) = delete;
    void set_vertices(std::span<const Eigen::Vector3d> positions)
    {
        for (std::size_t v = 0; v < positions.size(); ++v)
            for (std::size_t axis = 0; axis < 3; ++axis) vertices_[3 * v + axis] = btScalar(positions[v][int(axis)]);
    }
    btTriangleIndexVertexArray* arrays() const { return arrays_.get(); }

private:
    std::vector<btScalar> vertices_;
    std::vector<int> indices_;
    std::unique_ptr<btTriangleIndexVertexArray> arrays_;
};

/// A world of collision objects.
struct BulletSpace {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broad;
    btCollisionWorld world{&dispatcher, &broad, &configuration};
};

} // namespace bullet
} // namespace oncollide::tools
