#include "peers/narrow_peer.hpp"

#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

namespace oncollide::tools {
namespace {

/// A mesh in Bullet's form and precision. Bullet keeps pointers into these arrays.
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
        part = std::make_unique<btGImpactMeshShapePart>(arrays_.get(), 0);
        part->setMargin(0);
        part->updateBound();
        part->lockChildShapes();
    }
    ~BulletMesh() { part->unlockChildShapes(); }
    BulletMesh(const BulletMesh&) = delete;
    BulletMesh& operator=(const BulletMesh&) = delete;

private:
    std::vector<btScalar> vertices_;
    std::vector<int> indices_;
    std::unique_ptr<btTriangleIndexVertexArray> arrays_;

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

    BulletMesh a_, b_;
    btTransform pose_ = btTransform::getIdentity(); ///< of b
    btPairSet candidates_;
};

} // namespace

void add_narrow_bullet(std::vector<NarrowContender>& all)
{
    all.push_back({.name = "bullet-gimpact",
                   .what = "Bullet btGImpactMeshShape, margin 0, single precision",
                   .promise = NarrowContender::Promise::approximate,
                   .has_all_pairs = true,
                   .make = [](const Mesh& a, const Mesh& b) { return std::make_unique<BulletNarrowPeer>(a, b); }});
}

} // namespace oncollide::tools
