#include "peers/peer.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide::tools {
namespace {

/// The broad phase of the library, told which boxes moved or, as most others are, nothing: then all boxes are taken in
/// and all are searched, frame by frame.
class OwnPeer final : public BroadPeer {
public:
    OwnPeer(std::unique_ptr<BroadPhase> broad, bool told) : broad_(std::move(broad)), told_(told) {}

    void start(const BoxFrame& frame) override
    {
        std::vector<std::uint32_t> resting, moving;
        for (std::uint32_t body = 0; body < frame.boxes.size(); ++body) {
            (frame.is_static[body] ? resting : moving).push_back(body);
            if (!told_) all_.push_back(body);
        }
        broad_->add(resting, true), broad_->add(moving);
    }

    void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) override
    {
        broad_->move(told_ ? frame.moved : all_);
        const std::span<const BodyPair> found = broad_->find_pairs({.boxes = frame.boxes}, !told_);
        pairs.assign(found.begin(), found.end());
    }

    std::string remark() override
    {
        if (!told_) return {};
        const std::span<const DelimitationLevel> levels = broad_->levels();
        if (levels.empty()) return "delimitation off: over a quarter of the boxes changed";
        std::string text = "delimitation by level, rejected:";
        for (const DelimitationLevel& level : levels.subspan(std::min<std::size_t>(1, levels.size())))
            text += fmt::format(" {} of {} regions with {} boxes, {:.0f} % of the volume out of play, {:.4f} ms;",
                                level.regions_rejected, level.regions, level.bodies_rejected,
                                100 * level.volume_rejected, level.ms);
        return text += fmt::format(" {} boxes left", broad_->bodies_left());
    }

private:
    std::unique_ptr<BroadPhase> broad_;
    bool told_;
    std::vector<std::uint32_t> all_;
};

} // namespace

void add_oncollide(std::vector<Contender>& all)
{
    struct Algorithm {
        const char *name, *what;
        std::unique_ptr<BroadPhase> (*make)(const BroadPhase::Options&);
        bool told;
    };
    for (Algorithm a : {Algorithm{"kd", "oncollide kd-tree", make_kd_tree, false},
                        Algorithm{"octree", "oncollide octree", make_octree, false},
                        Algorithm{"dynamic", "oncollide kd-tree, delimited", make_kd_tree, true}})
        all.push_back({.name = a.name,
                       .what = a.what,
                       .group = Contender::Group::oncollide,
                       .threaded = true,
                       .make = [a](int threads) -> std::unique_ptr<BroadPeer> {
                           return std::make_unique<OwnPeer>(a.make({.threads = threads}), a.told);
                       }});
}

} // namespace oncollide::tools
