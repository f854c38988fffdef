// Bodies and scenes of the tests and of the benchmark.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include <assimp/scene.h>
#include <dart/dart.hpp>

#include <oncollide/dart/detector.hpp>
#include <oncollide/samples/generators.hpp>

namespace dart::collision::oncollide_client::tests {

/// A box around the origin whose sides are cut into n x n squares, two triangles each.
inline oncollide::Mesh box_mesh(const Eigen::Vector3d& size, int n)
{
    std::vector<Eigen::Vector3d> vertices;
    std::vector<oncollide::Triangle> triangles;
    for (int side = 0; side < 6; ++side) {
        const int axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        const double sign = side % 2 ? 1 : -1;
        const auto first = static_cast<std::uint32_t>(vertices.size()), row = static_cast<std::uint32_t>(n + 1);
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n; ++j) {
                Eigen::Vector3d p;
                p[axis] = sign / 2, p[u] = double(i) / n - 0.5, p[v] = double(j) / n - 0.5;
                vertices.push_back(p.cwiseProduct(size));
            }
        for (std::uint32_t i = 0; i + 1 < row; ++i)
            for (std::uint32_t j = 0; j + 1 < row; ++j) {
                const std::uint32_t a = first + i * row + j, b = a + row, c = b + 1, d = a + 1;
                for (oncollide::Triangle t : {oncollide::Triangle{a, b, c}, oncollide::Triangle{a, c, d}}) {
                    if (sign < 0) std::swap(t[1], t[2]);
                    triangles.push_back(t);
                }
            }
    }
    return oncollide::make_mesh("box", std::move(vertices), std::move(triangles));
}

/// A ring around z, of n segments; inner = 0: a cylinder.
inline oncollide::Mesh ring_mesh(double inner, double outer, double height, std::uint32_t n)
{
    std::vector<Eigen::Vector3d> vertices;
    std::vector<oncollide::Triangle> triangles;
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) { // counter-clockwise
        triangles.push_back({a, b, c}), triangles.push_back({a, c, d});
    };
    for (std::uint32_t i = 0; i < n; ++i) { // of each segment: outer low and high, inner high and low
        const double angle = 2 * EIGEN_PI * i / n;
        for (const auto& [r, z] :
             {std::pair(outer, -0.5), std::pair(outer, 0.5), std::pair(inner, 0.5), std::pair(inner, -0.5)})
            vertices.emplace_back(r * std::cos(angle), r * std::sin(angle), z * height);
        const std::uint32_t here = 4 * i, next = 4 * ((i + 1) % n);
        for (std::uint32_t k = 0; k < 4; ++k)
            if (inner > 0 || k != 2) add(here + k, next + k, next + (k + 1) % 4, here + (k + 1) % 4);
    }
    return oncollide::make_mesh("ring", std::move(vertices), std::move(triangles));
}

/// As Assimp's reader gives it, with flat normals: no two triangles share a vertex. The scene is DART's; it is released
/// with the process, as DART releases only scenes that Assimp made.
inline aiScene* scene_of(const oncollide::Mesh& mesh)
{
    auto* scene = new aiScene;
    auto* part = new aiMesh;
    part->mNumVertices = static_cast<unsigned>(3 * mesh.triangles.size());
    part->mVertices = new aiVector3D[part->mNumVertices];
    part->mNormals = new aiVector3D[part->mNumVertices];
    part->mNumFaces = static_cast<unsigned>(mesh.triangles.size());
    part->mFaces = new aiFace[part->mNumFaces];
    for (unsigned f = 0; f < part->mNumFaces; ++f) {
        part->mFaces[f].mNumIndices = 3, part->mFaces[f].mIndices = new unsigned[3];
        for (unsigned k = 0; k < 3; ++k) {
            const Eigen::Vector3f v = mesh.vertices[mesh.triangles[f][k]].cast<float>();
            part->mVertices[3 * f + k] = aiVector3D(v.x(), v.y(), v.z());
            part->mFaces[f].mIndices[k] = 3 * f + k;
        }
    }
    scene->mNumMeshes = 1, scene->mMeshes = new aiMesh* [1] { part };
    scene->mRootNode = new aiNode;
    return scene;
}

inline dynamics::ShapePtr mesh_shape(const oncollide::Mesh& mesh)
{
    return std::make_shared<dynamics::MeshShape>(Eigen::Vector3d::Ones(), scene_of(mesh));
}

inline void give_shape(dynamics::BodyNode* body, const dynamics::ShapePtr& shape, double friction)
{
    auto* node = body->createShapeNodeWith<dynamics::CollisionAspect, dynamics::DynamicsAspect>(shape);
    node->getDynamicsAspect()->setFrictionCoeff(friction);
}

inline dynamics::SkeletonPtr fixed(const dynamics::ShapePtr& shape, const std::string& name, double friction = 1,
                                   const Eigen::Isometry3d& at = Eigen::Isometry3d::Identity())
{
    auto skeleton = dynamics::Skeleton::create(name);
    auto [joint, body] = skeleton->createJointAndBodyNodePair<dynamics::WeldJoint>();
    joint->setTransformFromParentBodyNode(at);
    give_shape(body, shape, friction);
    return skeleton;
}

inline dynamics::SkeletonPtr free_body(const dynamics::ShapePtr& shape, const std::string& name,
                                       const Eigen::Isometry3d& at, double mass, const Eigen::Matrix3d& inertia,
                                       double friction = 1)
{
    auto skeleton = dynamics::Skeleton::create(name);
    auto [joint, body] = skeleton->createJointAndBodyNodePair<dynamics::FreeJoint>();
    joint->setTransform(at);
    body->setInertia(dynamics::Inertia(mass, Eigen::Vector3d::Zero(), inertia));
    give_shape(body, shape, friction);
    return skeleton;
}

/// Boxes of 1 m on a plane, one on the other; cuts = 0: primitives, otherwise meshes of 12 cuts^2 triangles.
inline simulation::WorldPtr stack(const std::shared_ptr<CollisionDetector>& detector, int boxes, int cuts)
{
    auto world = simulation::World::create();
    world->getConstraintSolver()->setCollisionDetector(detector);
    const dynamics::ShapePtr ground = std::make_shared<dynamics::BoxShape>(Eigen::Vector3d(10, 10, 1));
    world->addSkeleton(fixed(ground, "ground", 1, Eigen::Isometry3d(Eigen::Translation3d(0, 0, -0.5))));
    dynamics::ShapePtr shape = std::make_shared<dynamics::BoxShape>(Eigen::Vector3d::Ones());
    if (cuts > 0) shape = mesh_shape(box_mesh(Eigen::Vector3d::Ones(), cuts));
    for (int k = 0; k < boxes; ++k)
        world->addSkeleton(free_body(shape, "body " + std::to_string(k),
                                     Eigen::Isometry3d(Eigen::Translation3d(0, 0, k + 0.5)), 1,
                                     Eigen::Matrix3d::Identity() / 6));
    return world;
}

} // namespace dart::collision::oncollide_client::tests
