#pragma once
#include <memory>
#include <vector>

#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::tools {

/// A mesh in Bullet's form and precision. Bullet's shapes keep pointers into it.
class BulletMesh {
public:
    explicit BulletMesh(const Mesh& mesh)
    {
        for (const Eigen::Vector3d& v : mesh.vertices)
            for (int axis = 0; axis < 3; ++axis) vertices_.push_back(btScalar(v[axis]));
        for (const Triangle& t : mesh.triangles) indices_.insert(indices_.end(), t.begin(), t.end());
        arrays_ = std::make_unique<btTriangleIndexVertexArray>(int(mesh.triangles.size()), indices_.data(),
                                                               int(3 * sizeof(int)), int(mesh.vertices.size()),
                                                               vertices_.data(), int(3 * sizeof(btScalar)));
    }
    BulletMesh(const BulletMesh&) = delete;
    BulletMesh& operator=(const BulletMesh&) = delete;
    btTriangleIndexVertexArray* arrays() const { return arrays_.get(); }

private:
    std::vector<btScalar> vertices_;
    std::vector<int> indices_;
    std::unique_ptr<btTriangleIndexVertexArray> arrays_;
};

} // namespace oncollide::tools
