#include "peers/peers.hpp"

#include <deque>
#include <map>
#include <type_traits>

#include <fcl/fcl.h>

#include "fcl/fcl_pair.hpp"

namespace oncollide::tools {
namespace {

// FCL's collision managers without its narrow phase: the objects' boxes are set directly, and the callback stores the
// pair. SaPCollisionManager is left out: it corrupts memory when a box's lower face moves up while its upper face does
// not move.
class BoxObject final : public fcl::CollisionObject<double> {
public:
    BoxObject(const std::shared_ptr<fcl::CollisionGeometryd>& geometry, std::uint32_t number)
        : fcl::CollisionObject<double>(geometry), number_(number)
    {
    }
    void set(const Aabb& box) { aabb.min_ = box.min, aabb.max_ = box.max; }
    std::uint32_t number() const { return number_; }

private:
    std::uint32_t number_;
};

bool take_boxes(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* pairs)
{
    // Some managers call back for boxes that only share a cell or an interval.
    if (a->getAABB().overlap(b->getAABB()))
        static_cast<std::vector<BodyPair>*>(pairs)->push_back(
            {static_cast<BoxObject*>(a)->number(), static_cast<BoxObject*>(b)->number()});
    return false; // continue
}

using Hash = fcl::SpatialHashingCollisionManagerd<>;
using IntervalTree = fcl::IntervalTreeCollisionManagerd;

template <class Manager>
std::unique_ptr<Manager> make_manager(std::span<const Aabb> boxes)
{
    if constexpr (std::is_same_v<Manager, Hash>) {
        Aabb world;
        double edges = 0;
        for (const Aabb& box : boxes) world.add(box), edges += (box.max - box.min).maxCoeff();
        const double edge = 2 * edges / double(boxes.size());
        return std::make_unique<Hash>(edge, world.min, world.max, unsigned(2 * boxes.size() + 1));
    } else {
        return std::make_unique<Manager>();
    }
}

/// One manager for moving and one for static boxes, so that pairs of static boxes are never formed.
template <class Manager>
class FclBroadPeer final : public BroadPeer {
public:
    void start(const BoxFrame& frame) override
    {
        movers_ = make_manager<Manager>(frame.boxes);
        statics_ = make_manager<Manager>(frame.boxes);
        const auto geometry = std::make_shared<fcl::Boxd>(1, 1, 1);
        std::vector<fcl::CollisionObjectd*> movers, statics;
        for (std::uint32_t i = 0; i < frame.boxes.size(); ++i) {
            objects_.emplace_back(geometry, i).set(frame.boxes[i]);
            (frame.is_static[i] ? statics : movers).push_back(&objects_[i]);
        }
        mover_count_ = movers.size();
        if (!movers.empty()) movers_->registerObjects(movers);
        if (!statics.empty()) statics_->registerObjects(statics);
        movers_->setup(), statics_->setup();
    }

    void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) override
    {
        moved_.clear();
        for (std::uint32_t i : frame.moved) {
            objects_[i].set(frame.boxes[i]);
            moved_.push_back(&objects_[i]);
        }
        // The interval tree misses pairs if only the moved objects are given. The other managers are faster with them
        // if they are few.
        if (std::is_same_v<Manager, IntervalTree> || 4 * moved_.size() > mover_count_)
            movers_->update();
        else
            movers_->update(moved_);
        pairs.clear();
        if (mover_count_ == 0) return;
        movers_->collide(&pairs, take_boxes);
        if (mover_count_ < objects_.size()) movers_->collide(statics_.get(), &pairs, take_boxes);
    }

private:
    std::deque<BoxObject> objects_;
    std::unique_ptr<fcl::BroadPhaseCollisionManagerd> movers_, statics_;
    std::size_t mover_count_ = 0;
    std::vector<fcl::CollisionObjectd*> moved_;
};

class FclNarrowPeer final : public NarrowPeer {
public:
    FclNarrowPeer(const Mesh& a, const Mesh& b, FclNodes nodes) : pair_(a, b, nodes) {}

    bool collides(const Eigen::Isometry3d& b) override { return pair_.collides(b); }
    void all_pairs(const Eigen::Isometry3d& b, std::vector<TrianglePair>& pairs) override
    {
        pairs.clear();
        pair_.for_pairs(b, [&](std::uint32_t first, std::uint32_t second) { pairs.push_back({first, second}); });
    }
    double distance(const Eigen::Isometry3d& b) override { return pair_.distance(b); }

private:
    FclPair pair_;
};

class FclContactPeer final : public ContactPeer {
public:
    explicit FclContactPeer(std::span<const ContactPeerBody> bodies) : bodies_(bodies.begin(), bodies.end())
    {
        std::map<const Geometry*, FclGeometry> models;
        for (const ContactPeerBody& body : bodies) {
            FclGeometry& model = models[body.geometry];
            if (!model) model = make_fcl_geometry(body.geometry->data, FclNodes::obb);
            objects_.push_back(std::make_unique<fcl::CollisionObjectd>(model, body.pose));
            objects_.back()->setUserData(&bodies_[objects_.size() - 1]);
            tree_.registerObject(objects_.back().get());
        }
        tree_.setup();
    }
    void place(std::span<const Eigen::Isometry3d> poses) override
    {
        for (std::size_t i = 0; i < poses.size(); ++i) objects_[i]->setTransform(poses[i]), objects_[i]->computeAABB();
    }
    std::size_t contacts() override
    {
        tree_.update();
        count_ = 0;
        tree_.collide(this, take);
        return count_;
    }
    std::size_t contacts_of(std::span<const BodyPair> pairs) override
    {
        count_ = 0;
        for (const auto& [a, b] : pairs) take(objects_[a].get(), objects_[b].get(), this);
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

template <class Manager>
BroadContender fcl_manager(const char* name, const char* manager, std::size_t most = ~std::size_t{0})
{
    return {.name = name, .what = std::string("FCL ") + manager, .most = most, .make = [](int) {
                return std::make_unique<FclBroadPeer<Manager>>();
            }};
}

} // namespace

void add_fcl(Contenders& all)
{
    all.broad.all.push_back(fcl_manager<fcl::DynamicAABBTreeCollisionManagerd>("fcl-tree", "DynamicAABBTree"));
    all.broad.all.push_back(
        fcl_manager<fcl::DynamicAABBTreeCollisionManager_Arrayd>("fcl-array", "DynamicAABBTree_Array"));
    all.broad.all.push_back(fcl_manager<fcl::SSaPCollisionManagerd>("fcl-ssap", "SSaP", 10'000));
    all.broad.all.push_back(fcl_manager<Hash>("fcl-hash", "SpatialHashing", 10'000));
    all.broad.all.push_back(fcl_manager<IntervalTree>("fcl-interval", "IntervalTree", 10'000));
    all.narrow.all.push_back({.name = "fcl-obb",
                              .what = "FCL BVHModel<OBB>, no contacts",
                              .has_all_pairs = true,
                              .make = maker<FclNarrowPeer>(FclNodes::obb)});
    all.narrow.all.push_back({.name = "fcl-obbrss",
                              .what = "FCL BVHModel<OBBRSS>, no contacts",
                              .has_all_pairs = true,
                              .has_distance = true,
                              .make = maker<FclNarrowPeer>(FclNodes::obbrss)});
    all.contacts.all.push_back({.name = "fcl",
                                .what = "FCL collide, at most 1,000 contacts a pair, OBB models",
                                .promise = Promise::approximate,
                                .make = maker<FclContactPeer>()});
}

} // namespace oncollide::tools
