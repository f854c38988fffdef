// The stages above refinement: bounds, delimitation, broad.
#include <algorithm>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/pipeline/world/stage.hpp>

namespace oncollide {

namespace {

/// Updates the world AABBs of changed bodies: tight, or if skipped around bounding spheres.
class BoundsStage final : public Stage {
public:
    StageId id() const override { return StageId::bounds; }
    std::string_view unit() const override { return "bodies"; }
    void run(BodyTable& bodies, Frame& frame, StageStats& stats) override { update(bodies, frame, true, stats); }
    void skip(BodyTable& bodies, Frame& frame, StageStats& stats) override { update(bodies, frame, false, stats); }

private:
    static void update(BodyTable& bodies, const Frame& frame, bool tight, StageStats& stats)
    {
        update_boxes(bodies, frame.changes, tight, frame.context.threads);
        stats.in = stats.out = bodies.size();
    }
};

/// Applies the changes to the broad phase and finds the regions near them.
class DelimitationStage final : public Stage {
public:
    explicit DelimitationStage(BroadPhase& broad) : broad_(broad) {}
    StageId id() const override { return StageId::delimitation; }
    std::string_view unit() const override { return "bodies"; }
    std::string_view reason_to_skip(const BodyTable& bodies, const Frame& frame) const override
    {
        if (bodies.size() < 64) return "fewer than 64 bodies";
        if (4 * frame.moved > bodies.size()) return "over a quarter of the bodies moved";
        return {};
    }

    void run(BodyTable& bodies, Frame& frame, StageStats& stats) override
    {
        broad_.delimit(bodies.columns());
        frame.delimitation.assign(broad_.levels().begin(), broad_.levels().end());
        stats.in = bodies.size();
        stats.out = broad_.bodies_left();
    }

    void skip(BodyTable& bodies, Frame& frame, StageStats& stats) override
    {
        frame.delimitation.clear();
        stats.in = stats.out = bodies.size();
    }

private:
    BroadPhase& broad_;
};

class BroadStage final : public Stage {
public:
    explicit BroadStage(BroadPhase& broad) : broad_(broad) {}
    StageId id() const override { return StageId::broad; }
    std::string_view unit() const override { return "pairs"; }

    void run(BodyTable& bodies, Frame& frame, StageStats& stats) override
    {
        const std::span<const BodyPair> pairs = broad_.find_pairs(bodies.columns(), frame.whole);
        frame.pairs.assign(pairs.begin(), pairs.end());
        leave(bodies, frame);
        count(bodies, frame, frame.delimitation.empty() ? bodies.size() : broad_.bodies_left(), stats);
    }

    void skip(BodyTable& bodies, Frame& frame, StageStats& stats) override
    {
        survivors_.clear();
        if (frame.delimitation.empty())
            for (std::uint32_t slot = 0; slot < bodies.slots(); ++slot) {
                if (bodies.alive(slot)) survivors_.push_back(slot);
            }
        else
            broad_.survivors(survivors_);
        const BodyColumns columns = bodies.columns();
        frame.pairs.clear();
        for (std::size_t i = 0; i < survivors_.size(); ++i)
            for (std::size_t j = i + 1; j < survivors_.size(); ++j) {
                const std::uint32_t a = survivors_[i], b = survivors_[j];
                if (!(bodies.is_static(a) && bodies.is_static(b)) && columns.allows(a, b))
                    frame.pairs.push_back({a, b});
            }
        leave(bodies, frame);
        count(bodies, frame, survivors_.size(), stats);
    }

private:
    void leave(const BodyTable& bodies, Frame& frame)
    {
        if (bodies.any_excluded())
            std::erase_if(frame.pairs, [&](BodyPair pair) { return bodies.excluded(pair.a, pair.b); });
        if (frame.filter) filter(bodies, frame);
    }

    /// Applies the caller's filter, run by run.
    void filter(const BodyTable& bodies, Frame& frame)
    {
        constexpr std::size_t run = 1024;
        std::size_t kept = 0;
        bool swapped = false;
        for (std::size_t begin = 0; begin < frame.pairs.size(); begin += run) {
            const std::span<BodyPair> pairs =
                std::span(frame.pairs).subspan(begin).first(std::min(run, frame.pairs.size() - begin));
            candidates_.clear();
            for (const BodyPair pair : pairs)
                candidates_.push_back(
                    {bodies.id(pair.a), bodies.id(pair.b), bodies.boxes()[pair.a], bodies.boxes()[pair.b]});
            choices_.assign(pairs.size(), PairChoice::refine);
            frame.filter(candidates_, choices_);
            for (std::size_t i = 0; i < pairs.size(); ++i) {
                if (choices_[i] == PairChoice::drop) continue;
                const bool swap = choices_[i] == PairChoice::refine_swapped;
                frame.pairs[kept++] = swap ? BodyPair{pairs[i].b, pairs[i].a} : pairs[i];
                swapped |= swap;
            }
        }
        frame.pairs.resize(kept);
        if (swapped) std::ranges::sort(frame.pairs);
    }

    /// stats.in is the number of pairs of `left` bodies that are not both static, if they include all dynamic bodies.
    static void count(const BodyTable& bodies, const Frame& frame, std::uint64_t left, StageStats& stats)
    {
        const auto pairs = [](std::uint64_t n) { return n * (n - (n > 0)) / 2; };
        stats.in = std::max<std::uint64_t>(pairs(left) - pairs(left - std::min<std::uint64_t>(bodies.dynamic(), left)),
                                           frame.pairs.size());
        stats.out = frame.pairs.size();
    }

    BroadPhase& broad_;
    std::vector<std::uint32_t> survivors_;
    std::vector<CandidatePair> candidates_;
    std::vector<PairChoice> choices_;
};

} // namespace

std::unique_ptr<Stage> make_bounds_stage()
{
    return std::make_unique<BoundsStage>();
}
std::unique_ptr<Stage> make_delimitation_stage(BroadPhase& broad)
{
    return std::make_unique<DelimitationStage>(broad);
}
std::unique_ptr<Stage> make_broad_stage(BroadPhase& broad)
{
    return std::make_unique<BroadStage>(broad);
}

} // namespace oncollide
