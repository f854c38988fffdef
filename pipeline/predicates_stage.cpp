#include <optional>

#include <oncollide/narrowphase/exact_fcl.hpp>
#include <oncollide/narrowphase/mesh_leaf_test.hpp>
#include <oncollide/narrowphase/solid.hpp>
#include <oncollide/pipeline/exact_stages.hpp>
#include <oncollide/pipeline/pair_walks.hpp>
#include <oncollide/scenes/parallel.hpp>

namespace oncollide {

namespace {

/// Exact predicates on the pairs of meshes that the sphere-trees left over: the trees are walked on, and the triangles
/// of leaves that touch decide. Where a shape or a map takes part, and for distances within a clearance, FCL is asked.
class PredicatesStage final : public Stage {
public:
    PredicatesStage(const Scene& scene, const Settings& settings, Forest& forest)
        : fcl_(scene, settings.clearance), clearance_(settings.clearance)
    {
        if (settings.mode == Mode::solid) solid_.emplace(scene);
        // The triangles must be at hand. A GPU backend has them far away: then the trees are grown once more, here.
        if (!forest.backend().lists()) own_.emplace(scene, with_cpu(settings), make_cpu_backend());
        forest_ = own_ ? &*own_ : &forest;
        walks_.emplace(*forest_);
        test_.emplace(scene, *forest_->backend().lists());
    }
    std::string_view name() const override { return "exact"; }
    std::string_view unit() const override { return "pairs"; }
    std::string_view reason_to_skip(const Scene&, const Frame& frame) const override { return off_unless_asked(frame); }

    void run(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        find_open(scene, frame);
        walks_->run(scene, frame, open_, &*test_);
        decided_.clear();
        for (std::size_t i = 0; i < open_.size(); ++i) {
            const PairWalks::Walk& walk = open_[i];
            PairResult& result = frame.results[results_[i]];
            if (walk.result.status == WalkStatus::undecided) { // a budget: FCL needs no cells
                others_.push_back(results_[i]);
                continue;
            }
            const bool meet = walk.result.status == WalkStatus::touching;
            if (meet)
                decide(result, Verdict::colliding, 0);
            else if (solid_ && solid_->encloses(scene, walk.pair.a, walk.pair.b))
                decide(result, Verdict::colliding, 0);
            else if (clearance_ > 0)
                others_.push_back(results_[i]);
            else
                decide(result, Verdict::separate, 0);
            if (meet && frame.settings->coherence) decided_.push_back({walk.pair, walk.result.leaves});
        }
        ask_fcl(scene, frame);
        stats.in = open_.size() + asked_;
        for (const PairResult& result : frame.results)
            stats.out += result.stage == exact_stage_index && result.verdict != Verdict::separate;
        if (own_) own_->age(frame.number);
    }

    void skip(const Scene&, Frame& frame, StageStats& stats) override { pass_on(frame, stats); }

private:
    struct Decided {
        BodyPair pair;
        LeafPair leaves;
    };

    static Settings with_cpu(Settings settings)
    {
        settings.backend = BackendKind::cpu;
        return settings;
    }

    static void decide(PairResult& result, Verdict verdict, double bound)
    {
        result.verdict = verdict, result.bound = bound, result.stage = exact_stage_index;
    }

    /// Results and what was decided last frame are sorted by pair: one pass.
    void find_open(const Scene& scene, const Frame& frame)
    {
        open_.clear(), results_.clear(), others_.clear();
        asked_ = 0;
        auto last = decided_.begin();
        for (std::uint32_t i = 0; i < frame.results.size(); ++i) {
            if (!open(frame.results[i])) continue;
            const BodyPair pair{index(frame.results[i].a), index(frame.results[i].b)};
            if (!fcl_.both_meshes(scene, pair.a, pair.b)) {
                others_.push_back(i), ++asked_;
                continue;
            }
            while (last != decided_.end() && last->pair < pair) ++last;
            const bool known = last != decided_.end() && last->pair == pair;
            open_.push_back({pair, known ? last->leaves : LeafPair{}, {}});
            results_.push_back(i);
        }
    }

    void ask_fcl(const Scene& scene, Frame& frame)
    {
        for (std::uint32_t i : others_)
            for (BodyId body : {frame.results[i].a, frame.results[i].b}) fcl_.prepare(scene.geometry[index(body)]);
        parallel_chunks(others_.size(), 32, frame.threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t k = begin; k < end; ++k) {
                PairResult& result = frame.results[others_[k]];
                const std::uint32_t a = index(result.a), b = index(result.b);
                const ExactFcl::Answer answer = fcl_.answer(scene, a, b);
                const bool inside = answer.verdict == Verdict::separate && solid_ && solid_->encloses(scene, a, b);
                decide(result, inside ? Verdict::colliding : answer.verdict, inside ? 0 : answer.bound);
            }
        });
    }

    std::optional<Forest> own_;
    Forest* forest_ = nullptr;
    std::optional<PairWalks> walks_;
    std::optional<MeshLeafTest> test_;
    ExactFcl fcl_;
    double clearance_;
    std::optional<SolidTest> solid_;
    std::vector<PairWalks::Walk> open_;  ///< pairs of meshes without a verdict
    std::vector<std::uint32_t> results_; ///< theirs, in frame.results
    std::vector<std::uint32_t> others_;  ///< results that FCL is asked about
    std::uint64_t asked_ = 0;            ///< of these, not pairs of meshes
    std::vector<Decided> decided_;       ///< last frame's pairs that met, and where; sorted by pair
};

} // namespace

std::unique_ptr<Stage> make_predicates_stage(const Scene& scene, const Settings& settings, Forest& forest)
{
    return std::make_unique<PredicatesStage>(scene, settings, forest);
}

} // namespace oncollide
