// Bullet on meshes that deform.
#include "peers/bullet_gimpact.hpp"

namespace oncollide::tools {

using namespace bullet;

namespace {

/// The vertices in Bullet's precision, the tree refitted by updateBound(), and the two levels of
/// btGImpactCollisionAlgorithm without contacts.
class BulletDeformPeer final : public DeformPeer {
public:
    BulletDeformPeer(const Mesh& a, const Mesh& b) : a_(a), b_(b) {}

    void set_vertices(int which, std::span<const Eigen::Vector3d> positions) override
    {
        (which ? b_ : a_).set_vertices(positions);
    }
    void all_pairs(std::vector<TrianglePair>& pairs) override
    {
        const btTransform& rest = btTransform::getIdentity();
        pairs.clear(), candidates_.resizeNoInitialize(0);
        btGImpactBoxSet::find_collision(a_.part->getBoxSet(), rest, b_.part->getBoxSet(), rest, candidates_);
        for (int k = 0; k < candidates_.size(); ++k)
            if (gimpact_triangles_meet(a_, b_, rest, candidates_[k]))
                pairs.push_back({std::uint32_t(candidates_[k].m_index1), std::uint32_t(candidates_[k].m_index2)});
    }

private:
    GImpactMesh a_, b_;
    btPairSet candidates_;
};

} // namespace

void add_bullet_deform(Contenders& all)
{
    all.deform.all.push_back({.name = "bullet-gimpact",
                              .what = "Bullet btGImpactMeshShape, updateBound(); margin 0, single precision",
                              .promise = Promise::approximate,
                              .make = maker<BulletDeformPeer>()});
}

} // namespace oncollide::tools
