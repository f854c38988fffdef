#include "fcl/fcl_pair.hpp"
#include "peers/narrow/narrow_peer.hpp"

namespace oncollide::tools {
namespace {

class FclNarrow final : public NarrowPeer {
public:
    FclNarrow(const Mesh& a, const Mesh& b, FclNodes nodes) : pair_(a, b, nodes) {}

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

NarrowContender fcl_contender(const char* name, const char* what, FclNodes nodes)
{
    return {.name = name,
            .what = what,
            .has_all_pairs = true,
            .has_distance = nodes == FclNodes::obbrss,
            .make = [nodes](const Mesh& a, const Mesh& b) { return std::make_unique<FclNarrow>(a, b, nodes); }};
}

} // namespace

void add_narrow_fcl(std::vector<NarrowContender>& all)
{
    all.push_back(fcl_contender("fcl-obb", "FCL BVHModel<OBB>, no contacts", FclNodes::obb));
    all.push_back(fcl_contender("fcl-obbrss", "FCL BVHModel<OBBRSS>, no contacts", FclNodes::obbrss));
}

} // namespace oncollide::tools
