#include <oncollide/base/parallel.hpp>
#include <oncollide/narrowphase/exact/exact_fcl.hpp>
#include <oncollide/pipeline/containment_test.hpp>
#include <oncollide/pipeline/exact_stages.hpp>
#include <oncollide/pipeline/mesh_pairs.hpp>

namespace oncollide {

namespace {

/// Exact predicates on the pairs of meshes that are left over, by their trees of oriented boxes. FCL is asked where a
/// shape or a map takes part, or where a budget has no room for the trees.
class PredicatesStage final : public Stage {
public:
    PredicatesStage(const Scene& scene, const Settings& settings, Forest& forest)
        : mesh_pairs_(forest), fcl_(scene, settings.clearance), enclosures_(forest)
    {
    }
    std::string_view name() const override { return "exact"; }
    std::string_view unit() const override { return "pairs"; }
    std::string_view reason_to_skip(const Scene&, const Frame& frame) const override { return off_unless_asked(frame); }

    void run(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        find_open(scene, frame);
        mesh_pairs_.meet(scene, frame, asks_);
        for (std::size_t i = 0; i < asks_.size(); ++i) {
            const auto& [near, bound, meeting] = asks_[i].answer;
            const ContactKind kind = meeting ? kind_of(asks_[i].contact)
                                     : near  ? ContactKind::near
                                             : ContactKind::unknown;
            const bool ignored = frame.settings->ignore_touching && kind == ContactKind::touching;
            const Verdict verdict = ignored || !near ? Verdict::separate
                                    : meeting        ? Verdict::colliding
                                                     : Verdict::within;
            decide(frame.results[of_asks_[i]], verdict, kind, bound);
        }
        ask_fcl(scene, frame);
        enclosures_.find(scene, frame, exact_stage_index);
        stats.in = asks_.size() + others_.size();
        for (const PairResult& result : frame.results)
            stats.out += result.stage == exact_stage_index && result.verdict != Verdict::separate;
    }

    void skip(const Scene&, Frame& frame, StageStats& stats) override { pass_on(frame, stats); }

private:
    static ContactKind kind_of(TriangleContact contact)
    {
        return contact == TriangleContact::crossing   ? ContactKind::crossing
               : contact == TriangleContact::touching ? ContactKind::touching
                                                      : ContactKind::unknown;
    }

    static void decide(PairResult& result, Verdict verdict, ContactKind kind, double bound)
    {
        result.verdict = verdict, result.kind = kind, result.bound = bound, result.stage = exact_stage_index;
    }

    void find_open(const Scene& scene, const Frame& frame)
    {
        asks_.clear(), of_asks_.clear(), others_.clear();
        for (std::uint32_t i = 0; i < frame.results.size(); ++i) {
            if (!open(frame.results[i])) continue;
            const BodyPair pair{index(frame.results[i].a), index(frame.results[i].b)};
            if (mesh_pairs_.admit(scene, frame, pair))
                asks_.push_back({pair}), of_asks_.push_back(i);
            else
                others_.push_back(i);
        }
    }

    void ask_fcl(const Scene& scene, Frame& frame)
    {
        if (!fcl_available()) return; // they stay within their bound, or undecided
        for (std::uint32_t i : others_)
            for (BodyId body : {frame.results[i].a, frame.results[i].b}) fcl_.prepare(scene.geometry[index(body)]);
        parallel_chunks(others_.size(), 32, frame.threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t k = begin; k < end; ++k) {
                PairResult& result = frame.results[others_[k]];
                const ExactFcl::Answer answer = fcl_.answer(scene, index(result.a), index(result.b));
                decide(result, answer.verdict,
                       answer.verdict == Verdict::within ? ContactKind::near : ContactKind::unknown, answer.bound);
            }
        });
    }

    MeshPairs mesh_pairs_;
    ExactFcl fcl_;
    ContainmentTest enclosures_;
    std::vector<MeshPairs::Ask> asks_;   ///< pairs of meshes without a verdict
    std::vector<std::uint32_t> of_asks_; ///< theirs, in frame.results
    std::vector<std::uint32_t> others_;  ///< results that FCL is asked about
};

} // namespace

std::unique_ptr<Stage> make_predicates_stage(const Scene& scene, const Settings& settings, Forest& forest)
{
    return std::make_unique<PredicatesStage>(scene, settings, forest);
}

} // namespace oncollide
