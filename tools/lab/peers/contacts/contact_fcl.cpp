#include "peers/contacts/contact_peer.hpp"

#include <map>

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/narrowphase/collision.h>

#include "fcl/fcl_pair.hpp"

namespace oncollide::tools {
namespace {

class FclContactPeer final : public ContactPeer {
public:
    explicit FclContactPeer(std::span<const ContactPeerBody> bodies) : bodies_(bodies.begin(), bodies.end())
    {
        std::map<const Geometry*, FclGeometry> models;
        for (const ContactPeerBody& body : bodies) {
            FclGeometry& model = models[body.geometry];
            if (!model) model = make_fcl_geometry(body.geometry->data, FclNodes::obb);
            objects_.push_back(std::make_unique<fcl::CollisionObjectd>(model));
            objects_.back()->setUserData(&bodies_[objects_.size() - 1]);
            tree_.registerObject(objects_.back().get());
        }
        tree_.setup();
    }
    std::size_t contacts(std::span<const Eigen::Isometry3d> poses) override
    {
        for (std::size_t i = 0; i < poses.size(); ++i) objects_[i]->setTransform(poses[i]), objects_[i]->computeAABB();
        tree_.update();
        count_ = 0;
        tree_.collide(this, take);
        return count_;
    }

private:
    static bool take(fcl::CollisionObjectd* x, fcl::CollisionObjectd* y, void* data)
    {
        const auto is_static = [](const fcl::CollisionObjectd* object) {
            return static_cast<const ContactPeerBody*>(object->getUserData())->is_static;
        };
        if (is_static(x) && is_static(y)) return false;
        const fcl::CollisionRequestd request(1000, true);
        fcl::CollisionResultd result;
        fcl::collide(x, y, request, result);
        static_cast<FclContactPeer*>(data)->count_ += result.numContacts();
        return false; // continue
    }

    std::vector<ContactPeerBody> bodies_;
    std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects_;
    fcl::DynamicAABBTreeCollisionManagerd tree_;
    std::size_t count_ = 0;
};

} // namespace

void add_contact_fcl(std::vector<ContactContender>& all)
{
    all.push_back({.name = "fcl",
                   .what = "FCL collide, at most 1,000 contacts a pair, OBB models",
                   .promise = Promise::approximate,
                   .make = [](std::span<const ContactPeerBody> b) { return std::make_unique<FclContactPeer>(b); }});
}

} // namespace oncollide::tools
