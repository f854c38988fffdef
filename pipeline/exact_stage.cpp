#include <oncollide/narrowphase/exact_fcl.hpp>
#include <oncollide/narrowphase/solid.hpp>
#include <oncollide/pipeline/stage.hpp>
#include <oncollide/scenes/parallel.hpp>

namespace oncollide {

namespace {

/// Asks FCL about every pair that the sphere-trees left over.
class ExactStage final : public Stage {
public:
    ExactStage(const Scene& scene, const Settings& settings) : fcl_(scene, settings.clearance)
    {
        if (settings.mode == Mode::solid) solid_.emplace(scene);
    }
    std::string_view name() const override { return "exact"; }
    std::string_view unit() const override { return "pairs"; }
    std::string_view reason_to_skip(const Scene&, const Frame& frame) const override
    {
        return frame.settings->exact == ExactLevel::off ? "off" : std::string_view{};
    }

    void run(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        open_.clear();
        for (std::uint32_t i = 0; i < frame.results.size(); ++i) {
            const PairResult& result = frame.results[i];
            if (result.verdict == Verdict::separate || result.verdict == Verdict::colliding) continue;
            open_.push_back(i);
            fcl_.prepare(scene.geometry[index(result.a)]);
            fcl_.prepare(scene.geometry[index(result.b)]);
        }
        parallel_chunks(open_.size(), 64, frame.threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) decide(scene, frame.results[open_[i]]);
        });
        stats.in = open_.size();
        for (std::uint32_t i : open_) stats.out += frame.results[i].verdict != Verdict::separate;
    }

    void skip(const Scene&, Frame& frame, StageStats& stats) override
    {
        for (const PairResult& result : frame.results) {
            stats.in += result.verdict != Verdict::separate;
            stats.undecided += result.verdict == Verdict::undecided;
        }
        stats.out = stats.in;
    }

private:
    static constexpr std::uint8_t stage_index = 4;

    void decide(const Scene& scene, PairResult& result) const
    {
        const std::uint32_t a = index(result.a), b = index(result.b);
        auto [verdict, bound] = fcl_.answer(scene, a, b);
        if (verdict == Verdict::separate && solid_ && solid_->encloses(scene, a, b)) verdict = Verdict::colliding, bound = 0;
        result.verdict = verdict, result.bound = bound, result.stage = stage_index;
    }

    ExactFcl fcl_;
    std::optional<SolidTest> solid_;
    std::vector<std::uint32_t> open_; ///< results that are still open
};

} // namespace

std::unique_ptr<Stage> make_exact_stage(const Scene& scene, const Settings& settings)
{
    return std::make_unique<ExactStage>(scene, settings);
}

} // namespace oncollide
