#include <algorithm>

#include <oncollide/narrowphase/solid.hpp>
#include <oncollide/pipeline/pair_walks.hpp>
#include <oncollide/pipeline/stage.hpp>

namespace oncollide {

namespace {

/// Walks the sphere-trees of every candidate pair.
class OcstStage final : public Stage {
public:
    OcstStage(const Scene& scene, const Settings& settings, Forest& forest) : pair_walks_(forest)
    {
        if (settings.mode == Mode::solid) solid_.emplace(scene);
    }
    std::string_view name() const override { return "ocst"; }
    std::string_view unit() const override { return "pairs"; }

    void run(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        frame.trees = {}, frame.rounds.clear();
        stats.in = frame.pairs.size();
        walks_.resize(frame.pairs.size());
        find_hints(frame);
        pair_walks_.run(scene, frame, walks_, nullptr);
        finish(scene, frame, stats);
        for (const Round& round : frame.rounds) {
            stats.gpu_ms += round.work.gpu_ms, stats.wait_ms += round.work.wait_ms;
            frame.trees.rows += round.rows, frame.trees.queries += round.work.queries;
            frame.trees.gpu_bytes += round.work.bytes, frame.trees.repeats += round.work.repeats;
        }
        frame.trees.rounds = frame.rounds.size();
    }

    void skip(const Scene&, Frame& frame, StageStats& stats) override
    {
        frame.trees = {}, frame.rounds.clear();
        frame.results.resize(frame.pairs.size());
        for (std::size_t i = 0; i < frame.pairs.size(); ++i) {
            const BodyPair pair = frame.pairs[i];
            Aabb both = frame.boxes[pair.a];
            both.add(frame.boxes[pair.b]);
            // Both bodies have points in the box around the two. Its squared edges may underflow.
            const double diagonal = (both.max - both.min).stableNorm();
            frame.results[i] = {BodyId{pair.a}, BodyId{pair.b}, Verdict::undecided, stage_index, diagonal};
        }
        stats.in = stats.out = stats.undecided = frame.pairs.size();
    }

    static constexpr std::uint8_t stage_index = 3;

private:
    struct Decided {
        BodyPair pair;
        LeafPair leaves;
    };

    /// Both lists are sorted by pair: one pass.
    void find_hints(const Frame& frame)
    {
        auto last = decided_.begin();
        for (std::size_t i = 0; i < frame.pairs.size(); ++i) {
            while (last != decided_.end() && last->pair < frame.pairs[i]) ++last;
            const bool known = last != decided_.end() && last->pair == frame.pairs[i];
            walks_[i] = {frame.pairs[i], known ? last->leaves : LeafPair{}, {}};
        }
    }

    void finish(const Scene& scene, Frame& frame, StageStats& stats)
    {
        frame.results.resize(frame.pairs.size());
        decided_.clear();
        for (std::size_t i = 0; i < frame.pairs.size(); ++i) {
            const WalkResult& walk = walks_[i].result;
            const auto [a, b] = frame.pairs[i];
            Verdict verdict = Verdict::undecided;
            double bound = walk.bound;
            if (walk.status == WalkStatus::touching) {
                verdict = Verdict::within;
                if (frame.settings->coherence) decided_.push_back({frame.pairs[i], walk.leaves});
            } else if (walk.status == WalkStatus::separate) {
                verdict = Verdict::separate;
                if (solid_ && solid_->encloses(scene, a, b)) verdict = Verdict::colliding, bound = 0;
            }
            stats.out += verdict != Verdict::separate;
            stats.undecided += verdict == Verdict::undecided;
            frame.results[i] = {BodyId{a}, BodyId{b}, verdict, stage_index, bound};
        }
    }

    PairWalks pair_walks_;
    std::optional<SolidTest> solid_;
    std::vector<PairWalks::Walk> walks_; ///< by pair
    std::vector<Decided> decided_;       ///< last frame's touching pairs and the leaves that showed it
};

} // namespace

std::unique_ptr<Stage> make_ocst_stage(const Scene& scene, const Settings& settings, Forest& forest)
{
    return std::make_unique<OcstStage>(scene, settings, forest);
}

} // namespace oncollide
