#include "peers/narrow_peer.hpp"

#include "peers/fcl_pair.hpp"

namespace oncollide::tools {
namespace {

template <class Volume>
class FclNarrowPeer final : public NarrowPeer {
public:
    FclNarrowPeer(const Mesh& a, const Mesh& b) : models_(a, b) {}

    bool collides(const Eigen::Isometry3d& b) override { return models_.collide(b) > 0; }

    void all_pairs(const Eigen::Isometry3d& b, std::vector<TrianglePair>& pairs) override
    {
        pairs.clear();
        models_.all_pairs(b, [&](std::uint32_t i, std::uint32_t j) { pairs.push_back({i, j}); });
    }

    double distance(const Eigen::Isometry3d& b) override { return models_.distance(b); }

private:
    FclPair<Volume> models_;
};

template <class Volume>
NarrowContender contender(const char* name, const char* what, bool answers_distance)
{
    return {.name = name,
            .what = what,
            .answers_all = true,
            .answers_distance = answers_distance,
            .make = [](const Mesh& a, const Mesh& b) { return std::make_unique<FclNarrowPeer<Volume>>(a, b); }};
}

} // namespace

void add_narrow_fcl(std::vector<NarrowContender>& all)
{
    all.push_back(contender<fcl::OBBd>("fcl-obb", "FCL BVHModel<OBB>, no contacts", false));
    all.push_back(contender<fcl::OBBRSSd>("fcl-obbrss", "FCL BVHModel<OBBRSS>, no contacts", true));
}

} // namespace oncollide::tools
