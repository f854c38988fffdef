#include "bench/paper/culling_stage.hpp"

#include <set>
#include <utility>
#include <vector>

namespace oncollide::tools {
namespace {

class CullingStage final : public Stage {
public:
    CullingStage(std::unique_ptr<Stage> refine, std::unique_ptr<PairCulling> culling)
        : refine_(std::move(refine)), culling_(std::move(culling))
    {
    }
    StageId id() const override { return refine_->id(); }
    std::string_view unit() const override { return refine_->unit(); }
    std::string_view reason_to_skip(const BodyTable& bodies, const Frame& frame) const override
    {
        return refine_->reason_to_skip(bodies, frame);
    }

    void run(BodyTable& bodies, Frame& frame, StageStats& stats) override
    {
        refine_->skip(bodies, frame, stats); // lists every pair as undecided
        rows_.clear(), pairs_.clear(), culled_.resize(bodies.slots());
        for (std::uint32_t i = 0; i < frame.results.size(); ++i) {
            const std::uint32_t a = frame.results[i].a.slot, b = frame.results[i].b.slot;
            if (!take(bodies, a) || !take(bodies, b)) continue;
            rows_.push_back(i), pairs_.push_back({a, b});
        }
        left_.resize(pairs_.size());
        const CullingWork work = culling_->cull(culled_, pairs_, left_);
        for (std::size_t k = 0; k < rows_.size(); ++k) {
            if (left_[k]) continue;
            static_cast<Finding&>(frame.results[rows_[k]]) = {Verdict::separate, ContactKind::unknown, 0};
            --stats.out, --stats.undecided;
        }
        frame.context.trees.queries += work.queries, stats.gpu_ms += work.gpu_ms;
    }
    void skip(BodyTable& bodies, Frame& frame, StageStats& stats) override { refine_->skip(bodies, frame, stats); }

private:
    /// False if the body is no mesh.
    bool take(const BodyTable& bodies, std::uint32_t slot)
    {
        const Model& model = bodies.model(slot);
        if (!model.is_mesh()) return false;
        if (attached_.insert(model.number()).second) culling_->attach(model.number(), *model.mesh());
        culled_[slot] = {model.number(), bodies.pose(slot)};
        return true;
    }

    std::unique_ptr<Stage> refine_;
    std::unique_ptr<PairCulling> culling_;
    std::set<std::uint32_t> attached_; ///< numbers of models
    std::vector<CulledBody> culled_;   ///< by slot
    std::vector<std::uint32_t> rows_;  ///< of the pairs of meshes in the frame's results
    std::vector<BodyPair> pairs_;
    std::vector<std::uint8_t> left_;
};

} // namespace

std::unique_ptr<Stage> make_culling_stage(std::unique_ptr<Stage> refine, std::unique_ptr<PairCulling> culling)
{
    return std::make_unique<CullingStage>(std::move(refine), std::move(culling));
}

} // namespace oncollide::tools
