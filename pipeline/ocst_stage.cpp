#include <algorithm>

#include <oncollide/pipeline/containment_test.hpp>
#include <oncollide/pipeline/mesh_pairs.hpp>
#include <oncollide/pipeline/pair_walks.hpp>
#include <oncollide/pipeline/stage.hpp>

namespace oncollide {

namespace {

/// Walks the sphere-trees of every candidate pair; with tight spheres, the oriented boxes of meshes. These lead on to
/// the triangles, so where predicates decide, pairs of meshes are left to the exact level from the start.
class OcstStage final : public Stage {
public:
    OcstStage(const Settings& settings, Forest& forest)
        : tight_(wants_obbs(settings)),
          left_to_exact_(settings.exact == ExactLevel::predicates && std::ranges::count(settings.skip, "exact") == 0),
          pair_walks_(forest), mesh_pairs_(forest), enclosures_(forest)
    {
    }
    std::string_view name() const override { return "ocst"; }
    std::string_view unit() const override { return "pairs"; }

    void run(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        frame.trees = {}, frame.rounds.clear();
        stats.in = frame.pairs.size();
        frame.results.resize(frame.pairs.size());
        sort_out(scene, frame, stats);
        mesh_pairs_.near(scene, frame, asks_);
        for (std::size_t i = 0; i < asks_.size(); ++i) {
            const auto& [near, bound, meeting] = asks_[i].answer;
            decide(frame, stats, of_asks_[i], near ? Verdict::within : Verdict::separate, bound);
        }
        find_hints();
        pair_walks_.run(scene, frame, walks_);
        take_walks(frame, stats);
        stats.out += enclosures_.find(scene, frame, stage_index);
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
        for (std::size_t i = 0; i < frame.pairs.size(); ++i) frame.results[i] = undecided(frame, frame.pairs[i]);
        stats.in = stats.out = stats.undecided = frame.pairs.size();
    }

    static constexpr std::uint8_t stage_index = 3;

private:
    struct Decided {
        BodyPair pair;
        LeafPair leaves;
    };

    static PairResult undecided(const Frame& frame, BodyPair pair)
    {
        Aabb both = frame.boxes[pair.a];
        both.add(frame.boxes[pair.b]);
        // Both bodies have points in the box around the two. Its squared edges may underflow.
        const double diagonal = (both.max - both.min).stableNorm();
        return {BodyId{pair.a}, BodyId{pair.b}, Verdict::undecided, stage_index, ContactKind::unknown, diagonal};
    }

    /// Who answers which pair?
    void sort_out(const Scene& scene, Frame& frame, StageStats& stats)
    {
        walks_.clear(), of_walks_.clear(), asks_.clear(), of_asks_.clear();
        for (std::uint32_t i = 0; i < frame.pairs.size(); ++i) {
            const BodyPair pair = frame.pairs[i];
            if (!tight_ || !mesh_pairs_.admit(scene, frame, pair)) {
                walks_.push_back({pair, {}, {}}), of_walks_.push_back(i);
            } else if (!left_to_exact_) {
                asks_.push_back({pair}), of_asks_.push_back(i);
            } else {
                frame.results[i] = undecided(frame, pair);
                ++stats.out;
            }
        }
    }

    /// Both lists are sorted by pair: one pass.
    void find_hints()
    {
        auto last = decided_.begin();
        for (PairWalks::Walk& walk : walks_) {
            while (last != decided_.end() && last->pair < walk.pair) ++last;
            if (last != decided_.end() && last->pair == walk.pair) walk.hint = last->leaves;
        }
    }

    static void decide(Frame& frame, StageStats& stats, std::uint32_t i, Verdict verdict, double bound)
    {
        const auto [a, b] = frame.pairs[i];
        stats.out += verdict != Verdict::separate;
        stats.undecided += verdict == Verdict::undecided;
        frame.results[i] = {BodyId{a}, BodyId{b}, verdict, stage_index, ContactKind::unknown, bound};
    }

    void take_walks(Frame& frame, StageStats& stats)
    {
        decided_.clear();
        for (std::size_t i = 0; i < walks_.size(); ++i) {
            const auto& [pair, hint, walk] = walks_[i];
            const Verdict verdict = walk.status == WalkStatus::touching   ? Verdict::within
                                    : walk.status == WalkStatus::separate ? Verdict::separate
                                                                          : Verdict::undecided;
            if (verdict == Verdict::within && frame.settings->coherence) decided_.push_back({pair, walk.leaves});
            decide(frame, stats, of_walks_[i], verdict, walk.bound);
        }
    }

    const bool tight_;
    const bool left_to_exact_; ///< pairs of meshes, if tight
    PairWalks pair_walks_;
    MeshPairs mesh_pairs_;
    ContainmentTest enclosures_;
    std::vector<PairWalks::Walk> walks_;
    std::vector<MeshPairs::Ask> asks_;
    std::vector<std::uint32_t> of_walks_, of_asks_; ///< their numbers among the pairs
    std::vector<Decided> decided_;                  ///< last frame's touching pairs and the leaves that showed it
};

} // namespace

std::unique_ptr<Stage> make_ocst_stage(const Settings& settings, Forest& forest)
{
    return std::make_unique<OcstStage>(settings, forest);
}

} // namespace oncollide
