// CGAL's box intersection is under the GPL: it serves only this comparison; the installed libraries do not contain it.
#include "peers/broad/broad_peer.hpp"

#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/box_intersection_d.h>

namespace oncollide::tools {
namespace {

using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint32_t>;

/// Streamed segment trees, rebuilt each frame.
class CgalPeer final : public BroadPeer {
public:
    void start(const BoxFrame&) override {}

    void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) override
    {
        movers_.clear(), statics_.clear(), pairs.clear();
        for (std::uint32_t i = 0; i < frame.boxes.size(); ++i) {
            Aabb box = frame.boxes[i];
            (frame.is_static[i] ? statics_ : movers_).emplace_back(box.min.data(), box.max.data(), i);
        }
        const auto take = [&](const Box& a, const Box& b) { pairs.push_back({a.info(), b.info()}); };
        CGAL::box_self_intersection_d(movers_.begin(), movers_.end(), take);
        if (!statics_.empty())
            CGAL::box_intersection_d(movers_.begin(), movers_.end(), statics_.begin(), statics_.end(), take);
    }

private:
    std::vector<Box> movers_, statics_; ///< CGAL reorders them
};

} // namespace

void add_cgal(std::vector<BroadContender>& all)
{
    all.push_back({.name = "cgal", .what = "CGAL box_self_intersection_d", .make = [](int) {
                       return std::make_unique<CgalPeer>();
                   }});
}

} // namespace oncollide::tools
