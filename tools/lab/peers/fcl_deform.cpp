// FCL on meshes that deform.
#include "peers/peers.hpp"

#include <oncollide/narrowphase/fcl/fcl_geometry.hpp>

namespace oncollide::tools {
namespace {

/// beginUpdateModel(), updateSubModel() and endUpdateModel(), which refits the tree from its leaves; collide() without
/// contact details, its fastest mode.
template <class Volume>
class FclDeformPeer final : public DeformPeer {
public:
    FclDeformPeer(const Mesh& a, const Mesh& b) : models_{make(a), make(b)} {}

    void set_vertices(int which, std::span<const Eigen::Vector3d> positions) override
    {
        moved_.assign(positions.begin(), positions.end());
        models_[which]->beginUpdateModel();
        models_[which]->updateSubModel(moved_);
        models_[which]->endUpdateModel(true, true);
    }
    void all_pairs(std::vector<TrianglePair>& pairs) override
    {
        const fcl::Transform3d rest = fcl::Transform3d::Identity();
        const fcl::CollisionRequestd request(1'000'000'000, false);
        pairs.clear(), result_.clear();
        fcl::collide(models_[0].get(), rest, models_[1].get(), rest, request, result_);
        for (std::size_t k = 0; k < result_.numContacts(); ++k) {
            const fcl::Contactd& contact = result_.getContact(k);
            pairs.push_back({std::uint32_t(contact.b1), std::uint32_t(contact.b2)});
        }
    }

private:
    using Model = fcl::BVHModel<Volume>;
    static std::shared_ptr<Model> make(const Mesh& mesh)
    {
        return std::static_pointer_cast<Model>(make_fcl_tree<Volume>(mesh));
    }

    std::shared_ptr<Model> models_[2];
    std::vector<fcl::Vector3d> moved_;
    fcl::CollisionResultd result_;
};

} // namespace

void add_fcl_deform(Contenders& all)
{
    const auto add = [&](const char* name, const char* what, auto make) {
        all.deform.all.push_back({.name = name, .what = what, .promise = Promise::approximate, .make = make});
    };
    add("fcl-obb", "FCL BVHModel<OBB>, refitted by endUpdateModel(), no contacts", maker<FclDeformPeer<fcl::OBBd>>());
    add("fcl-obbrss", "FCL BVHModel<OBBRSS>, the same", maker<FclDeformPeer<fcl::OBBRSSd>>());
    add("fcl-aabb", "FCL BVHModel<AABB>, the same", maker<FclDeformPeer<fcl::AABBd>>());
}

} // namespace oncollide::tools
