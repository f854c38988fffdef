#include "peers/common/bullet_mesh.hpp"
#include "peers/narrow/narrow_peer.hpp"

#include <BulletCollision/Gimpact/btGImpactShape.h>

namespace oncollide::tools {
namespace {

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
        const Eigen::Matrix3d& r = b.linear();
        const auto number = [](double x) { return btScalar(x); };
        pose_.setBasis({number(r(0, 0)), number(r(0, 1)), number(r(0, 2)), number(r(1, 0)), number(r(1, 1)),
                        number(r(1, 2)), number(r(2, 0)), number(r(2, 1)), number(r(2, 2))});
        pose_.setOrigin({number(b.translation().x()), number(b.translation().y()), number(b.translation().z())});
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

} // namespace

void add_narrow_bullet(std::vector<NarrowContender>& all)
{
    all.push_back({.name = "bullet-gimpact",
                   .what = "Bullet btGImpactMeshShape, margin 0, single precision",
                   .promise = Promise::approximate,
                   .has_all_pairs = true,
                   .make = [](const Mesh& a, const Mesh& b) { return std::make_unique<BulletNarrowPeer>(a, b); }});
}

} // namespace oncollide::tools
