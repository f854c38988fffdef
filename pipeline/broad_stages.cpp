// The stages above the sphere-trees: bounds, delimitation, broad.
#include <algorithm>
#include <numeric>

#include <oncollide/broadphase/dynamic_tree.hpp>
#include <oncollide/broadphase/world_boxes.hpp>
#include <oncollide/pipeline/stage.hpp>

namespace oncollide {

namespace {

std::vector<std::uint32_t> all_bodies(const Scene& scene)
{
    std::vector<std::uint32_t> all(scene.size());
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

std::vector<std::uint32_t> moving_bodies(const Scene& scene)
{
    std::vector<std::uint32_t> moving = all_bodies(scene);
    std::erase_if(moving, [&](std::uint32_t body) { return scene.is_static[body] != 0; });
    return moving;
}

/// World boxes: tight, or, skipped, those of spheres.
class BoundsStage final : public Stage {
public:
    explicit BoundsStage(const Scene& scene) : boxes_(scene), all_(all_bodies(scene)), moving_(moving_bodies(scene)) {}
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

/// Takes what moved into the tree and leaves the bodies of the regions that it reaches.
class DelimitationStage final : public Stage {
public:
    DelimitationStage(const Scene& scene, const Settings& settings, DynamicTree& tree)
        : tree_(tree), all_(all_bodies(scene)), moving_(moving_bodies(scene)),
          lists_survivors_(settings.broad_phase != BroadPhaseKind::kd_tree ||
                           std::ranges::count(settings.skip, "broad") > 0)
    {
    }
    std::string_view name() const override { return "delimitation"; }
    std::string_view unit() const override { return "bodies"; }
    std::string_view reason_to_skip(const Scene&, const Frame&) const override
    {
        if (all_.size() < 64) return "fewer than 64 bodies";
        if (4 * moving_.size() > all_.size()) return "over a quarter of the bodies may move";
        return {};
    }

    void run(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        if (tree_.size() == 0) {
            std::vector<std::uint32_t> resting = all_;
            std::erase_if(resting, [&](std::uint32_t body) { return !scene.is_static[body]; });
            tree_.add(resting, true), tree_.add(moving_);
        } else {
            tree_.move(moving_);
        }
        tree_.delimit({frame.boxes, scene.layers, scene.masks});
        frame.delimited = true;
        frame.delimitation.assign(tree_.levels().begin(), tree_.levels().end());
        if (lists_survivors_) tree_.survivors(frame.survivors);
        stats.in = scene.size();
        stats.out = tree_.bodies_left();
    }

    void skip(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        frame.delimited = false;
        frame.delimitation.clear();
        if (frame.survivors.size() != all_.size()) frame.survivors = all_;
        stats.in = stats.out = scene.size();
    }

private:
    DynamicTree& tree_;
    std::vector<std::uint32_t> all_, moving_;
    bool lists_survivors_; ///< the kd-tree goes on with the regions themselves
};

class BroadStage final : public Stage {
public:
    BroadStage(const Scene& scene, BroadPhaseKind kind, DynamicTree& tree)
        : tree_(tree), goes_on_(kind == BroadPhaseKind::kd_tree), moving_(moving_bodies(scene).size())
    {
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

    void run(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        if (goes_on_ && frame.delimited) {
            const std::span<const BodyPair> pairs = tree_.find_pairs({frame.boxes, scene.layers, scene.masks});
            frame.pairs.assign(pairs.begin(), pairs.end());
            // Those that move all survive: each is in its own region.
            stats.in = pairs_of(tree_.bodies_left(), moving_);
        } else {
            algorithm_->find_pairs(frame.boxes, frame.survivors, frame.filter, frame.settings->clearance, frame.threads,
                                   frame.pairs);
            stats.in = pairs_of_survivors(frame);
        }
        stats.out = frame.pairs.size();
    }

    void skip(const Scene&, Frame& frame, StageStats& stats) override
    {
        frame.pairs.clear();
        for (std::size_t i = 0; i < frame.survivors.size(); ++i)
            for (std::size_t j = i + 1; j < frame.survivors.size(); ++j)
                if (frame.filter.allows(frame.survivors[i], frame.survivors[j]))
                    frame.pairs.push_back({frame.survivors[i], frame.survivors[j]});
        stats.in = pairs_of_survivors(frame);
        stats.out = frame.pairs.size();
    }

private:
    /// Pairs of `bodies`, of which so many move, that are not both static.
    static std::uint64_t pairs_of(std::uint64_t bodies, std::uint64_t moving)
    {
        const auto pairs = [](std::uint64_t n) { return n * (n - (n > 0)) / 2; };
        return pairs(bodies) - pairs(bodies - std::min(moving, bodies));
    }
    static std::uint64_t pairs_of_survivors(const Frame& frame)
    {
        std::uint64_t moving = 0;
        for (std::uint32_t body : frame.survivors) moving += !frame.filter.is_static[body];
        return pairs_of(frame.survivors.size(), moving);
    }

    DynamicTree& tree_;
    bool goes_on_; ///< with what delimitation left in the tree
    std::uint64_t moving_;
    std::unique_ptr<BroadPhase> algorithm_;
};

} // namespace

std::unique_ptr<Stage> make_bounds_stage(const Scene& scene)
{
    return std::make_unique<BoundsStage>(scene);
}
std::unique_ptr<Stage> make_delimitation_stage(const Scene& scene, const Settings& settings, DynamicTree& tree)
{
    return std::make_unique<DelimitationStage>(scene, settings, tree);
}
std::unique_ptr<Stage> make_broad_stage(const Scene& scene, BroadPhaseKind kind, DynamicTree& tree)
{
    return std::make_unique<BroadStage>(scene, kind, tree);
}

} // namespace oncollide
