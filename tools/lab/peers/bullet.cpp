#include "peers/peers.hpp"

#include <map>

#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletCollisionCommon.h>

namespace oncollide::tools {
namespace {

btVector3 vector_of(const Eigen::Vector3d& p)
{
    return {btScalar(p.x()), btScalar(p.y()), btScalar(p.z())};
}

btTransform transform_of(const Eigen::Isometry3d& pose)
{
    const Eigen::Matrix3d rows = pose.linear().transpose();
    const btVector3 x = vector_of(rows.col(0)), y = vector_of(rows.col(1)), z = vector_of(rows.col(2));
    const btMatrix3x3 turn(x.x(), x.y(), x.z(), y.x(), y.y(), y.z(), z.x(), z.y(), z.z());
    return btTransform(turn, vector_of(pose.translation()));
}

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

/// A world of collision objects.
struct BulletSpace {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broad;
    btCollisionWorld world{&dispatcher, &broad, &configuration};
};

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

/// A mesh as one part of a GImpact shape.
class GImpactMesh {
public:
    explicit GImpactMesh(const Mesh& mesh)
        : mesh_(mesh), part(std::make_unique<btGImpactMeshShapePart>(mesh_.arrays(), 0))
    {
        part->setMargin(0);
        part->updateBound();
        part->lockChildShapes();
    }
    ~GImpactMesh() { part->unlockChildShapes(); }
    GImpactMesh(const GImpactMesh&) = delete;
    GImpactMesh& operator=(const GImpactMesh&) = delete;

private:
    BulletMesh mesh_;

public:
    std::unique_ptr<btGImpactMeshShapePart> part; ///< declared last: destroyed before the data it points to
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

    bool meet(const GIM_PAIR& pair) const
    {
        btPrimitiveTriangle p, q;
        a_.part->getPrimitiveTriangle(pair.m_index1, p), b_.part->getPrimitiveTriangle(pair.m_index2, q);
        p.m_margin = q.m_margin = 0;
        q.applyTransform(pose_);
        p.buildTriPlane(), q.buildTriPlane();
        GIM_TRIANGLE_CONTACT contact;
        return p.overlap_test_conservative(q) && p.find_triangle_collision_clip_method(q, contact);
    }

    GImpactMesh a_, b_;
    btTransform pose_ = btTransform::getIdentity(); ///< of b
    btPairSet candidates_;
};

/// Moving meshes are GImpact shapes, still ones trees of triangles.
class BulletContactPeer final : public ContactPeer {
public:
    explicit BulletContactPeer(std::span<const ContactPeerBody> bodies)
    {
        btGImpactCollisionAlgorithm::registerAlgorithm(&space_.dispatcher);
        for (const ContactPeerBody& body : bodies) {
            auto& shape = shapes_[{body.geometry, body.is_static}];
            if (!shape) shape = make_shape(body);
            auto& object = objects_.emplace_back(std::make_unique<btCollisionObject>());
            object->setCollisionShape(shape.get());
            object->setCollisionFlags(body.is_static ? btCollisionObject::CF_STATIC_OBJECT : 0);
            space_.world.addCollisionObject(object.get(), body.is_static ? 1 : 2, body.is_static ? 2 : 3);
        }
    }
    ~BulletContactPeer() override
    {
        for (const auto& object : objects_) space_.world.removeCollisionObject(object.get());
    }
    std::size_t contacts(std::span<const Eigen::Isometry3d> poses) override
    {
        for (std::size_t i = 0; i < poses.size(); ++i) objects_[i]->setWorldTransform(transform_of(poses[i]));
        space_.world.performDiscreteCollisionDetection();
        std::size_t count = 0;
        for (int i = 0; i < space_.dispatcher.getNumManifolds(); ++i)
            count += static_cast<std::size_t>(space_.dispatcher.getManifoldByIndexInternal(i)->getNumContacts());
        return count;
    }

private:
    std::unique_ptr<btCollisionShape> make_shape(const ContactPeerBody& body)
    {
        const auto* mesh = std::get_if<Mesh>(&body.geometry->data);
        if (!mesh)
            return std::make_unique<btBoxShape>(vector_of(std::get<Box>(std::get<Shape>(body.geometry->data)).half));
        auto& data = meshes_[body.geometry];
        if (!data) data = std::make_unique<BulletMesh>(*mesh);
        if (body.is_static) return std::make_unique<btBvhTriangleMeshShape>(data->arrays(), true);
        auto shape = std::make_unique<btGImpactMeshShape>(data->arrays());
        shape->updateBound();
        return shape;
    }

    BulletSpace space_;
    std::map<const Geometry*, std::unique_ptr<BulletMesh>> meshes_;
    std::map<std::pair<const Geometry*, bool>, std::unique_ptr<btCollisionShape>> shapes_;
    std::vector<std::unique_ptr<btCollisionObject>> objects_;
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
    all.contacts.all.push_back({.name = "bullet",
                                .what = "Bullet btCollisionWorld, moving meshes as GImpact",
                                .promise = Promise::approximate,
                                .make = maker<BulletContactPeer>()});
}

} // namespace oncollide::tools
