#include "peer.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include <oncollide/broadphase/delimitation.hpp>

namespace oncollide::tools {
namespace {

/// The broad stages of the pipeline without the pipeline.
class OncollidePeer final : public BroadPeer {
public:
    OncollidePeer(std::unique_ptr<BroadPhase> algorithm, bool delimited, int threads)
        : algorithm_(std::move(algorithm)), delimited_(delimited), threads_(threads)
    {
    }

    void start(const BoxFrame& frame) override
    {
        bodies_.resize(frame.boxes.size());
        std::iota(bodies_.begin(), bodies_.end(), 0u);
        everything_.assign(frame.boxes.size(), ~0u);
        first_ = true;
    }

    void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) override
    {
        const BodyFilter filter{frame.is_static, everything_, everything_};
        if (delimited_) delimitation_.run(frame.boxes, filter, 0, survivors_);
        if (!algorithm_->follows_movers())
            algorithm_->find_pairs(frame.boxes, delimited_ ? survivors_ : bodies_, filter, 0, threads_, kept_);
        else if (std::exchange(first_, false))
            algorithm_->find_pairs(frame.boxes, bodies_, filter, 0, threads_, kept_);
        else
            algorithm_->update_pairs(frame.boxes, bodies_, frame.moved,
                                     delimited_ ? surviving_movers(frame) : frame.moved, filter, 0, threads_, kept_);
        pairs = kept_;
    }

private:
    std::span<const std::uint32_t> surviving_movers(const BoxFrame& frame)
    {
        asked_.clear();
        std::ranges::set_intersection(frame.moved, survivors_, std::back_inserter(asked_));
        return asked_;
    }

    std::unique_ptr<BroadPhase> algorithm_;
    Delimitation delimitation_;
    bool delimited_;
    int threads_;
    bool first_ = true;
    std::vector<std::uint32_t> bodies_, everything_, survivors_, asked_;
    std::vector<BodyPair> kept_; ///< the last frame's pairs
};

} // namespace

void add_oncollide(std::vector<Contender>& all)
{
    struct Algorithm {
        const char* name;
        std::unique_ptr<BroadPhase> (*make)();
    };
    for (Algorithm a : {Algorithm{"kd", make_kd_tree}, Algorithm{"octree", make_octree}})
        for (bool delimited : {false, true})
            all.push_back({.name = fmt::format("{}{}", a.name, delimited ? "-delimited" : ""),
                           .what = fmt::format("oncollide {}{}", a.name, delimited ? " after delimitation" : ""),
                           .group = Contender::Group::oncollide,
                           .threaded = true,
                           .needs_statics = delimited,
                           .make = [a, delimited](int threads) -> std::unique_ptr<BroadPeer> {
                               return std::make_unique<OncollidePeer>(a.make(), delimited, threads);
                           }});
}

} // namespace oncollide::tools
