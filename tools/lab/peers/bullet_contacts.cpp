// Contacts by Bullet: all bodies of a btCollisionWorld, or pairs one by one.
#include "peers/bullet_shapes.hpp"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>

namespace oncollide::tools {

using namespace bullet;

namespace {

/// An algorithm for one pair, and its contacts.
struct BulletPair {
    BulletPair(btCollisionDispatcher& of, const btCollisionObject& first, const btCollisionObject& second)
        : dispatcher(of), a(nullptr, first.getCollisionShape(), &first, first.getWorldTransform(), -1, -1),
          b(nullptr, second.getCollisionShape(), &second, second.getWorldTransform(), -1, -1),
          algorithm(of.findAlgorithm(&a, &b, nullptr, BT_CONTACT_POINT_ALGORITHMS))
    {
    }
    ~BulletPair()
    {
        algorithm->~btCollisionAlgorithm();
        dispatcher.freeCollisionAlgorithm(algorithm);
    }
    BulletPair(const BulletPair&) = delete;
    BulletPair& operator=(const BulletPair&) = delete;
    std::size_t contacts(const btDispatcherInfo& info)
    {
        if (manifold) manifold->clearManifold();
        btManifoldResult result(&a, &b);
        algorithm->processCollision(&a, &b, info, &result);
        if (!manifold) manifold = own_manifold();
        return static_cast<std::size_t>(manifold->getNumContacts());
    }
    btPersistentManifold* own_manifold()
    {
        btManifoldArray all;
        algorithm->getAllContactManifolds(all);
        return all[0];
    }

    btCollisionDispatcher& dispatcher;
    const btCollisionObjectWrapper a, b;
    btCollisionAlgorithm* algorithm;
    btPersistentManifold* manifold = nullptr; ///< of two convex shapes; the algorithm makes it with its first contact
};

/// Moving meshes are GImpact shapes, still ones trees of triangles. The world keeps its pairs with their contacts from
/// step to step, as an engine does.
class BulletContactPeer final : public ContactPeer {
public:
    explicit BulletContactPeer(std::span<const ContactPeerBody> bodies)
    {
        btGImpactCollisionAlgorithm::registerAlgorithm(&space_.dispatcher);
        for (const ContactPeerBody& body : bodies) {
            auto& object = objects_.emplace_back(std::make_unique<btCollisionObject>());
            const BulletShapes::Shape shape = shapes_.of(*body.geometry, body.is_static);
            geometries_.push_back(body.geometry);
            object->setCollisionShape(shape.shape), origins_.push_back(shape.origin);
            object->setCollisionFlags(body.is_static ? btCollisionObject::CF_STATIC_OBJECT : 0);
            place(objects_.size() - 1, body.pose);
            space_.world.addCollisionObject(object.get(), body.is_static ? 1 : 2, body.is_static ? 2 : 3);
        }
    }
    ~BulletContactPeer() override
    {
        pairs_.clear();
        for (const auto& object : objects_) space_.world.removeCollisionObject(object.get());
    }
    void place(std::span<const Eigen::Isometry3d> poses) override
    {
        for (std::size_t i = 0; i < poses.size(); ++i) place(i, poses[i]);
    }
    std::size_t contacts() override
    {
        space_.world.performDiscreteCollisionDetection();
        std::size_t count = 0;
        for (int i = 0; i < space_.dispatcher.getNumManifolds(); ++i)
            count += static_cast<std::size_t>(space_.dispatcher.getManifoldByIndexInternal(i)->getNumContacts());
        return count;
    }
    std::size_t contacts_of(std::span<const BodyPair> pairs) override
    {
        if (pairs_.empty())
            for (const auto& [a, b] : pairs)
                pairs_.push_back(std::make_unique<BulletPair>(space_.dispatcher, *objects_[a], *objects_[b]));
        std::size_t count = 0;
        for (const auto& pair : pairs_) count += pair->contacts(space_.world.getDispatchInfo());
        return count;
    }
    bool set_heights(std::size_t body, const TerrainRectangle& where, std::span<const double> heights) override
    {
        return shapes_.set_heights(*geometries_[body], where, heights), true;
    }

private:
    void place(std::size_t i, const Eigen::Isometry3d& pose)
    {
        objects_[i]->setWorldTransform(transform_of(pose * Eigen::Translation3d(origins_[i])));
    }
    BulletSpace space_;
    BulletShapes shapes_{false};
    std::vector<std::unique_ptr<btCollisionObject>> objects_;
    std::vector<const Geometry*> geometries_;
    std::vector<Eigen::Vector3d> origins_; ///< of the bodies' shapes, in the bodies' frames
    std::vector<std::unique_ptr<BulletPair>> pairs_;
};

} // namespace

void add_bullet_contacts(Contenders& all)
{
    all.contacts.all.push_back({.name = "bullet",
                                .what = "Bullet btCollisionWorld, moving meshes as GImpact; hulls, cones and "
                                        "ellipsoids with 1 mm around them",
                                .promise = Promise::approximate,
                                .make = maker<BulletContactPeer>()});
}

} // namespace oncollide::tools
