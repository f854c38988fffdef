#include "peers/broad/broad_peer.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide::tools {
namespace {

/// The library's own broad phase; it receives the list of moved boxes.
class OwnPeer final : public BroadPeer {
public:
    OwnPeer(std::unique_ptr<BroadPhase> broad, bool whole) : broad_(std::move(broad)), whole_(whole) {}

    void start(const BoxFrame& frame) override
    {
        std::vector<std::uint32_t> resting, moving;
        for (std::uint32_t body = 0; body < frame.boxes.size(); ++body)
            (frame.is_static[body] ? resting : moving).push_back(body);
        broad_->add(resting, true), broad_->add(moving);
    }

    void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) override
    {
        broad_->move(frame.moved);
        const std::span<const BodyPair> found = broad_->find_pairs({.boxes = frame.boxes}, whole_);
        pairs.assign(found.begin(), found.end());
    }

    BroadPhase* delimited() override { return whole_ ? nullptr : broad_.get(); }

private:
    std::unique_ptr<BroadPhase> broad_;
    bool whole_; ///< search all boxes, not only moved ones
};

} // namespace

void add_oncollide(std::vector<BroadContender>& all)
{
    struct Algorithm {
        const char *name, *what;
        std::unique_ptr<BroadPhase> (*make)(const BroadPhase::Options&);
        bool whole;
    };
    for (Algorithm a : {Algorithm{"kd", "oncollide kd-tree", make_kd_tree, true},
                        Algorithm{"octree", "oncollide octree", make_octree, true},
                        Algorithm{"dynamic", "oncollide kd-tree, delimited", make_kd_tree, false}})
        all.push_back({.name = a.name,
                       .what = a.what,
                       .group = Group::oncollide,
                       .threaded = true,
                       .make = [a](int threads) -> std::unique_ptr<BroadPeer> {
                           return std::make_unique<OwnPeer>(a.make({.threads = threads}), a.whole);
                       }});
}

} // namespace oncollide::tools
