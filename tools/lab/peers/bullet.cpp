#include "peers/bullet_gimpact.hpp"

#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>

namespace oncollide::tools {

using namespace bullet;

namespace {

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
    return std::make_unique<Sweep>(vector_of(world.min - margin), vector_of(world.max + margin),
                                   Number(frame.boxes.size() + 2));
}

/// Bullet keeps its pairs from frame to frame. Some of them are outdated or only nearly overlap, so they are tested
/// again.
class BulletBroadPeer final : public BroadPeer {
public:
    using Make = std::unique_ptr<btBroadphaseInterface> (*)(const BoxFrame&);
    explicit BulletBroadPeer(Make make) : make_(make) {}
    ~BulletBroadPeer() override
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
                vector_of(box.min), vector_of(box.max), 0, reinterpret_cast<void*>(std::uintptr_t{i}),
                is_static ? fixed : mover, is_static ? mover : mover | fixed, nullptr));
        }
    }

    void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) override
    {
        for (std::uint32_t i : frame.moved)
            broadphase_->setAabb(proxies_[i], vector_of(frame.boxes[i].min), vector_of(frame.boxes[i].max), nullptr);
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

/// The two levels of btGImpactCollisionAlgorithm without contacts: all pairs of AABBs, then triangles pair by pair.
class BulletNarrowPeer final : public NarrowPeer {
public:
    BulletNarrowPeer(const Mesh& a, const Mesh& b) : a_(a), b_(b) {}

    bool collides(const Eigen::Isometry3d& b) override
    {
        find_candidates(b);
        for (int k = 0; k < candidates_.size(); ++k)
            if (meet(candidates_[k])) return true;
        return false;
    }

    void all_pairs(const Eigen::Isometry3d& b, std::vector<TrianglePair>& pairs) override
    {
        pairs.clear();
        find_candidates(b);
        for (int k = 0; k < candidates_.size(); ++k)
            if (meet(candidates_[k]))
                pairs.push_back({std::uint32_t(candidates_[k].m_index1), std::uint32_t(candidates_[k].m_index2)});
    }

private:
    void find_candidates(const Eigen::Isometry3d& b)
    {
        pose_ = transform_of(b);
        candidates_.resizeNoInitialize(0);
        btGImpactBoxSet::find_collision(a_.part->getBoxSet(), btTransform::getIdentity(), b_.part->getBoxSet(), pose_,
                                        candidates_);
    }

    bool meet(const GIM_PAIR& pair) const { return gimpact_triangles_meet(a_, b_, pose_, pair); }

    GImpactMesh a_, b_;
    btTransform pose_ = btTransform::getIdentity(); ///< of b
    btPairSet candidates_;
};

/// A world of one static mesh.
class BulletRayPeer final : public RayPeer {
public:
    explicit BulletRayPeer(const Mesh& mesh) : mesh_(mesh), shape_(mesh_.arrays(), true)
    {
        body_.setCollisionShape(&shape_);
        space_.world.addCollisionObject(&body_);
    }
    ~BulletRayPeer() override { space_.world.removeCollisionObject(&body_); }
    BulletRayPeer(const BulletRayPeer&) = delete;
    BulletRayPeer& operator=(const BulletRayPeer&) = delete;

    void trace(std::span<const Segment> segments, std::span<std::uint8_t> hit) override
    {
        for (std::size_t i = 0; i < segments.size(); ++i) {
            const btVector3 from = vector_of(segments[i].from), to = vector_of(segments[i].to);
            btCollisionWorld::ClosestRayResultCallback found(from, to);
            space_.world.rayTest(from, to, found);
            hit[i] = found.hasHit();
        }
    }

private:
    BulletMesh mesh_;
    btBvhTriangleMeshShape shape_;
    btCollisionObject body_;
    BulletSpace space_;
};

BroadContender bullet_broad(const char* name, const char* what, BulletBroadPeer::Make make,
                            std::size_t most = ~std::size_t{0})
{
    return {.name = name, .what = what, .most = most, .make = [make](int) {
                return std::make_unique<BulletBroadPeer>(make);
            }};
}

} // namespace

void add_bullet(Contenders& all)
{
    all.broad.all.push_back(bullet_broad("bullet-dbvt", "Bullet btDbvtBroadphase, deferred", make_tree));
    // Each insertion costs time in proportion to the number of boxes: hours for a million boxes.
    all.broad.all.push_back(
        bullet_broad("bullet-sweep16", "Bullet btAxisSweep3", make_sweep<btAxisSweep3, unsigned short>, 10'000));
    all.broad.all.push_back(
        bullet_broad("bullet-sweep32", "Bullet bt32BitAxisSweep3", make_sweep<bt32BitAxisSweep3, unsigned>, 10'000));
    all.narrow.all.push_back({.name = "bullet-gimpact",
                              .what = "Bullet btGImpactMeshShape, margin 0, single precision",
                              .promise = Promise::approximate,
                              .has_all_pairs = true,
                              .make = maker<BulletNarrowPeer>()});
    all.rays.all.push_back(
        {.name = "bullet",
         .what = "Bullet rayTest, btBvhTriangleMeshShape, single precision; the closest hit",
         .promise = Promise::approximate,
         .most = std::size_t{1} << 21, // bits of a triangle's index in btQuantizedBvh; it crashes with more
         .make = maker<BulletRayPeer>()});
    add_bullet_contacts(all), add_bullet_deform(all), add_bullet_physics(all);
}

} // namespace oncollide::tools
