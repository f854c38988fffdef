#include "peers/contacts/contact_peer.hpp"

#include <map>

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletCollisionCommon.h>

#include "peers/common/bullet_mesh.hpp"

namespace oncollide::tools {
namespace {

/// Moving meshes are GImpact shapes, still ones trees of triangles.
class BulletContactPeer final : public ContactPeer {
public:
    explicit BulletContactPeer(std::span<const ContactPeerBody> bodies)
        : dispatcher_(&configuration_), world_(&dispatcher_, &broad_, &configuration_)
    {
        btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
        for (const ContactPeerBody& body : bodies) {
            auto& shape = shapes_[{body.geometry, body.is_static}];
            if (!shape) shape = make_shape(body);
            auto& object = objects_.emplace_back(std::make_unique<btCollisionObject>());
            object->setCollisionShape(shape.get());
            object->setCollisionFlags(body.is_static ? btCollisionObject::CF_STATIC_OBJECT : 0);
            world_.addCollisionObject(object.get(), body.is_static ? 1 : 2, body.is_static ? 2 : 3);
        }
    }
    ~BulletContactPeer() override
    {
        for (const auto& object : objects_) world_.removeCollisionObject(object.get());
    }
    std::size_t contacts(std::span<const Eigen::Isometry3d> poses) override
    {
        for (std::size_t i = 0; i < poses.size(); ++i) {
            const Eigen::Matrix3d& r = poses[i].linear();
            const Eigen::Vector3d& p = poses[i].translation();
            const auto scalar = [](double x) { return btScalar(x); };
            objects_[i]->setWorldTransform(btTransform(btMatrix3x3(scalar(r(0, 0)), scalar(r(0, 1)), scalar(r(0, 2)),
                                                                   scalar(r(1, 0)), scalar(r(1, 1)), scalar(r(1, 2)),
                                                                   scalar(r(2, 0)), scalar(r(2, 1)), scalar(r(2, 2))),
                                                       btVector3(scalar(p.x()), scalar(p.y()), scalar(p.z()))));
        }
        world_.performDiscreteCollisionDetection();
        std::size_t count = 0;
        for (int i = 0; i < dispatcher_.getNumManifolds(); ++i)
            count += static_cast<std::size_t>(dispatcher_.getManifoldByIndexInternal(i)->getNumContacts());
        return count;
    }

private:
    std::unique_ptr<btCollisionShape> make_shape(const ContactPeerBody& body)
    {
        const auto* mesh = std::get_if<Mesh>(&body.geometry->data);
        if (!mesh) {
            const Eigen::Vector3d half = std::get<Box>(std::get<Shape>(body.geometry->data)).half;
            return std::make_unique<btBoxShape>(btVector3(btScalar(half.x()), btScalar(half.y()), btScalar(half.z())));
        }
        auto& data = meshes_[body.geometry];
        if (!data) data = std::make_unique<BulletMesh>(*mesh);
        if (body.is_static) return std::make_unique<btBvhTriangleMeshShape>(data->arrays(), true);
        auto shape = std::make_unique<btGImpactMeshShape>(data->arrays());
        shape->updateBound();
        return shape;
    }

    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_;
    btDbvtBroadphase broad_;
    btCollisionWorld world_;
    std::map<const Geometry*, std::unique_ptr<BulletMesh>> meshes_;
    std::map<std::pair<const Geometry*, bool>, std::unique_ptr<btCollisionShape>> shapes_;
    std::vector<std::unique_ptr<btCollisionObject>> objects_;
};

} // namespace

void add_contact_bullet(std::vector<ContactContender>& all)
{
    all.push_back({.name = "bullet",
                   .what = "Bullet btCollisionWorld, moving meshes as GImpact",
                   .promise = Promise::approximate,
                   .make = [](std::span<const ContactPeerBody> b) { return std::make_unique<BulletContactPeer>(b); }});
}

} // namespace oncollide::tools
