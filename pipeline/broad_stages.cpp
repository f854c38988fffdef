// The stages above the sphere-trees: bounds, delimitation, broad.
#include <algorithm>
#include <numeric>
#include <utility>

#include <oncollide/broadphase/world_boxes.hpp>
#include <oncollide/pipeline/stage.hpp>

namespace oncollide {

namespace {

void keep_all_bodies(const Scene& scene, std::vector<std::uint32_t>& bodies)
{
    if (bodies.size() == scene.size()) return; // already the identity: it is only ever filled whole or by delimitation
    bodies.resize(scene.size());
    std::iota(bodies.begin(), bodies.end(), 0u);
}

/// World boxes: tight, or, skipped, those of spheres.
class BoundsStage final : public Stage {
public:
    explicit BoundsStage(const Scene& scene) : boxes_(scene)
    {
        for (std::uint32_t body = 0; body < scene.size(); ++body) {
            all_.push_back(body);
            if (!scene.is_static[body]) moving_.push_back(body);
        }
    }
    std::string_view name() const override { return "bounds"; }
    std::string_view unit() const override { return "bodies"; }

    void run(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        frame.boxes.resize(scene.size());
        boxes_.update(scene, first_ ? all_ : moving_, frame.threads, frame.boxes);
        first_ = false;
        stats.in = stats.out = scene.size();
    }

    void skip(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        frame.boxes.resize(scene.size());
        for (std::uint32_t body : all_) frame.boxes[body] = boxes_.sphere_box(scene, body);
        first_ = true;
        stats.in = stats.out = scene.size();
    }

private:
    WorldBoxes boxes_;
    std::vector<std::uint32_t> all_, moving_;
    bool first_ = true;
};

class DelimitationStage final : public Stage {
public:
    std::string_view name() const override { return "delimitation"; }
    std::string_view unit() const override { return "bodies"; }
    std::string_view reason_to_skip(const Scene&, const Frame& frame) const override
    {
        return Delimitation::reason_to_skip(frame.filter);
    }

    void run(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        regions_.run(frame.boxes, frame.filter, frame.settings->clearance, frame.survivors);
        frame.delimitation.assign(regions_.levels().begin(), regions_.levels().end());
        stats.in = scene.size();
        stats.out = frame.survivors.size();
    }

    void skip(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        keep_all_bodies(scene, frame.survivors);
        frame.delimitation.clear();
        stats.in = stats.out = scene.size();
    }

private:
    Delimitation regions_;
};

class BroadStage final : public Stage {
public:
    BroadStage(const Scene& scene, BroadPhaseKind kind)
    {
        for (std::uint32_t body = 0; body < scene.size(); ++body) {
            all_.push_back(body);
            if (!scene.is_static[body]) moving_.push_back(body);
        }
        switch (kind) {
        case BroadPhaseKind::kd_tree:
            algorithm_ = make_kd_tree();
            break;
        case BroadPhaseKind::octree:
            algorithm_ = make_octree();
            break;
        case BroadPhaseKind::brute_force:
            algorithm_ = make_brute_force();
            break;
        }
    }
    std::string_view name() const override { return "broad"; }
    std::string_view unit() const override { return "pairs"; }

    void run(const Scene&, Frame& frame, StageStats& stats) override
    {
        const double margin = frame.settings->clearance;
        if (!algorithm_->follows_movers())
            algorithm_->find_pairs(frame.boxes, frame.survivors, frame.filter, margin, frame.threads, frame.pairs);
        else if (std::exchange(first_, false))
            algorithm_->find_pairs(frame.boxes, all_, frame.filter, margin, frame.threads, frame.pairs);
        else
            algorithm_->update_pairs(frame.boxes, all_, moving_, surviving_movers(frame), frame.filter, margin,
                                     frame.threads, frame.pairs);
        stats.in = pairs_of(frame);
        stats.out = frame.pairs.size();
    }

    void skip(const Scene&, Frame& frame, StageStats& stats) override
    {
        frame.pairs.clear();
        for (std::size_t i = 0; i < frame.survivors.size(); ++i)
            for (std::size_t j = i + 1; j < frame.survivors.size(); ++j)
                if (frame.filter.allows(frame.survivors[i], frame.survivors[j]))
                    frame.pairs.push_back({frame.survivors[i], frame.survivors[j]});
        stats.in = pairs_of(frame);
        stats.out = frame.pairs.size();
    }

private:
    /// Delimitation found that the others can be in no pair.
    std::span<const std::uint32_t> surviving_movers(const Frame& frame)
    {
        if (frame.survivors.size() == all_.size()) return moving_;
        asked_.clear();
        for (std::uint32_t body : frame.survivors)
            if (!frame.filter.is_static[body]) asked_.push_back(body);
        return asked_;
    }

    /// Pairs of survivors that are not both static.
    static std::uint64_t pairs_of(const Frame& frame)
    {
        std::uint64_t statics = 0;
        for (std::uint32_t body : frame.survivors) statics += frame.filter.is_static[body];
        const std::uint64_t n = frame.survivors.size();
        return n * (n - (n > 0)) / 2 - statics * (statics - (statics > 0)) / 2;
    }

    std::unique_ptr<BroadPhase> algorithm_;
    std::vector<std::uint32_t> all_, moving_, asked_;
    bool first_ = true;
};

} // namespace

std::unique_ptr<Stage> make_bounds_stage(const Scene& scene)
{
    return std::make_unique<BoundsStage>(scene);
}
std::unique_ptr<Stage> make_delimitation_stage()
{
    return std::make_unique<DelimitationStage>();
}
std::unique_ptr<Stage> make_broad_stage(const Scene& scene, BroadPhaseKind kind)
{
    return std::make_unique<BroadStage>(scene, kind);
}

} // namespace oncollide
