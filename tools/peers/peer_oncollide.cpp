#include "peers/peer.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include <oncollide/broadphase/dynamic_tree.hpp>

namespace oncollide::tools {
namespace {

/// All boxes taken in and all searched, frame by frame.
class SearchPeer final : public BroadPeer {
public:
    SearchPeer(std::unique_ptr<BroadPhase> algorithm, int threads) : algorithm_(std::move(algorithm)), threads_(threads)
    {
    }

    void start(const BoxFrame& frame) override
    {
        bodies_.resize(frame.boxes.size());
        std::iota(bodies_.begin(), bodies_.end(), 0u);
        everything_.assign(frame.boxes.size(), ~0u);
    }

    void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) override
    {
        algorithm_->find_pairs(frame.boxes, bodies_, {frame.is_static, everything_, everything_}, 0, threads_, pairs);
    }

private:
    std::unique_ptr<BroadPhase> algorithm_;
    int threads_;
    std::vector<std::uint32_t> bodies_, everything_;
};

/// Delimitation and the accurate level on what moved; pairs kept from frame to frame.
class DynamicPeer final : public BroadPeer {
public:
    DynamicPeer(double fat, int threads) : tree_({.fat = fat, .threads = threads}) {}

    void start(const BoxFrame& frame) override
    {
        std::vector<std::uint32_t> resting, moving;
        for (std::uint32_t body = 0; body < frame.boxes.size(); ++body)
            (frame.is_static[body] ? resting : moving).push_back(body);
        tree_.add(resting, true), tree_.add(moving);
    }

    void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) override
    {
        tree_.move(frame.moved);
        const std::span<const BodyPair> found = tree_.find_pairs({frame.boxes});
        pairs.assign(found.begin(), found.end());
    }

    std::string remark() override
    {
        const std::span<const DelimitationLevel> levels = tree_.levels();
        if (levels.empty()) return "delimitation off: over a quarter of the boxes changed";
        std::string text = "delimitation by level, rejected:";
        for (const DelimitationLevel& level : levels.subspan(std::min<std::size_t>(1, levels.size())))
            text += fmt::format(" {} of {} regions with {} boxes, {:.0f} % of the volume out of play, {:.4f} ms;",
                                level.regions_rejected, level.regions, level.bodies_rejected,
                                100 * level.volume_rejected, level.ms);
        return text += fmt::format(" {} boxes left", tree_.bodies_left());
    }

private:
    DynamicTree tree_;
};

} // namespace

void add_oncollide(std::vector<Contender>& all)
{
    struct Algorithm {
        const char *name, *what;
        std::unique_ptr<BroadPhase> (*make)();
    };
    for (Algorithm a :
         {Algorithm{"kd", "oncollide kd-tree", make_kd_tree}, Algorithm{"octree", "oncollide octree", make_octree}})
        all.push_back({.name = a.name,
                       .what = a.what,
                       .group = Contender::Group::oncollide,
                       .threaded = true,
                       .make = [a](int threads) -> std::unique_ptr<BroadPeer> {
                           return std::make_unique<SearchPeer>(a.make(), threads);
                       }});
    struct Dynamic {
        const char *name, *what;
        double fat;
    };
    for (Dynamic d : {Dynamic{"dynamic", "oncollide kd-tree, delimited", 0},
                      Dynamic{"dynamic-fat", "the same, boxes 0.3 m fat", 0.3}})
        all.push_back({.name = d.name,
                       .what = d.what,
                       .group = Contender::Group::oncollide,
                       .threaded = true,
                       .make = [d](int threads) -> std::unique_ptr<BroadPeer> {
                           return std::make_unique<DynamicPeer>(d.fat, threads);
                       }});
}

} // namespace oncollide::tools
