#include "peers/broad/broad_peer.hpp"

#include <type_traits>

#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>

namespace oncollide::tools {
namespace {

btVector3 corner(const Eigen::Vector3d& p)
{
    return {btScalar(p.x()), btScalar(p.y()), btScalar(p.z())};
}

std::unique_ptr<btBroadphaseInterface> make_tree(const BoxFrame&)
{
    auto tree = std::make_unique<btDbvtBroadphase>();
    tree->m_deferedcollide = true; // all pairs of a frame together, which is faster if many boxes move
    return tree;
}

/// Sweep and prune with coordinates of the width of `Number`, in twice the room of the boxes at the start.
template <class Sweep, class Number>
std::unique_ptr<btBroadphaseInterface> make_sweep(const BoxFrame& frame)
{
    Aabb world;
    for (const Aabb& box : frame.boxes) world.add(box);
    const Eigen::Vector3d margin = 0.5 * world.half_extent() + Eigen::Vector3d::Ones();
    return std::make_unique<Sweep>(corner(world.min - margin), corner(world.max + margin),
                                   Number(frame.boxes.size() + 2));
}

/// Bullet keeps its pairs from frame to frame. Some of them are outdated or only nearly overlap, so they are tested
/// again.
class BulletPeer final : public BroadPeer {
public:
    using Make = std::unique_ptr<btBroadphaseInterface> (*)(const BoxFrame&);
    explicit BulletPeer(Make make) : make_(make) {}
    ~BulletPeer() override
    {
        for (btBroadphaseProxy* proxy : proxies_) broadphase_->destroyProxy(proxy, nullptr);
    }

    void start(const BoxFrame& frame) override
    {
        constexpr int mover = 1, fixed = 2;
        broadphase_ = make_(frame);
        for (std::uint32_t i = 0; i < frame.boxes.size(); ++i) {
            const bool is_static = frame.is_static[i];
            const Aabb& box = frame.boxes[i];
            proxies_.push_back(broadphase_->createProxy(
                corner(box.min), corner(box.max), 0, reinterpret_cast<void*>(std::uintptr_t{i}),
                is_static ? fixed : mover, is_static ? mover : mover | fixed, nullptr));
        }
    }

    void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) override
    {
        for (std::uint32_t i : frame.moved)
            broadphase_->setAabb(proxies_[i], corner(frame.boxes[i].min), corner(frame.boxes[i].max), nullptr);
        broadphase_->calculateOverlappingPairs(nullptr);
        const btBroadphasePairArray& found = broadphase_->getOverlappingPairCache()->getOverlappingPairArray();
        pairs.clear();
        for (int k = 0; k < found.size(); ++k) {
            const std::uint32_t a = number(found[k].m_pProxy0), b = number(found[k].m_pProxy1);
            if (frame.boxes[a].overlaps(frame.boxes[b])) pairs.push_back({a, b});
        }
    }

private:
    static std::uint32_t number(const btBroadphaseProxy* proxy)
    {
        return std::uint32_t(reinterpret_cast<std::uintptr_t>(proxy->m_clientObject));
    }

    Make make_;
    std::unique_ptr<btBroadphaseInterface> broadphase_;
    std::vector<btBroadphaseProxy*> proxies_;
};

BroadContender contender(const char* name, const char* what, BulletPeer::Make make, std::size_t most = ~std::size_t{0})
{
    return {
        .name = name, .what = what, .most = most, .make = [make](int) { return std::make_unique<BulletPeer>(make); }};
}

} // namespace

void add_bullet(std::vector<BroadContender>& all)
{
    all.push_back(contender("bullet-dbvt", "Bullet btDbvtBroadphase, deferred", make_tree));
    // Each insertion costs time in proportion to the number of boxes: hours for a million boxes.
    all.push_back(contender("bullet-sweep16", "Bullet btAxisSweep3", make_sweep<btAxisSweep3, unsigned short>, 10'000));
    all.push_back(
        contender("bullet-sweep32", "Bullet bt32BitAxisSweep3", make_sweep<bt32BitAxisSweep3, unsigned>, 10'000));
}

} // namespace oncollide::tools
