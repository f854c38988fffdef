// FCL's collision managers without its narrow phase: the objects' boxes are set directly, and the callback stores the
// pair. Its SaPCollisionManager is left out: it corrupts memory when a box's lower face moves up while its upper face
// does not move.
#include "peers/broad/broad_peer.hpp"

#include <deque>
#include <type_traits>

#include <fcl/fcl.h>

namespace oncollide::tools {
namespace {

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

bool take(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* pairs)
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
class FclPeer final : public BroadPeer {
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
        movers_->collide(&pairs, take);
        if (mover_count_ < objects_.size()) movers_->collide(statics_.get(), &pairs, take);
    }

private:
    std::deque<BoxObject> objects_;
    std::unique_ptr<fcl::BroadPhaseCollisionManagerd> movers_, statics_;
    std::size_t mover_count_ = 0;
    std::vector<fcl::CollisionObjectd*> moved_;
};

template <class Manager>
BroadContender contender(const char* name, const char* manager, std::size_t most = ~std::size_t{0})
{
    return {.name = name, .what = std::string("FCL ") + manager, .most = most, .make = [](int) {
                return std::make_unique<FclPeer<Manager>>();
            }};
}

} // namespace

void add_fcl(std::vector<BroadContender>& all)
{
    all.push_back(contender<fcl::DynamicAABBTreeCollisionManagerd>("fcl-tree", "DynamicAABBTree"));
    all.push_back(contender<fcl::DynamicAABBTreeCollisionManager_Arrayd>("fcl-array", "DynamicAABBTree_Array"));
    all.push_back(contender<fcl::SSaPCollisionManagerd>("fcl-ssap", "SSaP", 10'000));
    all.push_back(contender<Hash>("fcl-hash", "SpatialHashing", 10'000));
    all.push_back(contender<IntervalTree>("fcl-interval", "IntervalTree", 10'000));
}

} // namespace oncollide::tools
