// The stages above the sphere-trees: bounds, delimitation, broad.
#include <algorithm>
#include <numeric>

#include <oncollide/base/parallel.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/broadphase/pose_bounds.hpp>
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

/// The bounds of a scene's geometries, on which its bodies' boxes are based.
class WorldBoxes {
public:
    explicit WorldBoxes(const Scene& scene)
    {
        for (const Geometry& geometry : scene.geometries) bounds_.emplace_back(geometry.data);
    }
    void update(const Scene& scene, std::span<const std::uint32_t> bodies, int threads, std::span<Aabb> boxes)
    {
        counts_.assign(bounds_.size(), 0);
        for (std::uint32_t body : bodies) ++counts_[index(scene.geometry[body])];
        for (std::size_t g = 0; g < bounds_.size(); ++g) bounds_[g].expect(counts_[g]);
        parallel_chunks(bodies.size(), 2048, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i)
                boxes[bodies[i]] = bounds_[index(scene.geometry[bodies[i]])].box(scene.poses[bodies[i]]);
        });
    }
    Aabb sphere_box(const Scene& scene, std::uint32_t body) const
    {
        return bounds_[index(scene.geometry[body])].sphere_box(scene.poses[body]);
    }

private:
    std::vector<PoseBounds> bounds_; ///< by geometry
    std::vector<std::uint64_t> counts_;
};

/// Adds the bodies of the scene to `broad`, those that rest asleep; where they are there already, tells it who moves.
void add_or_move(BroadPhase& broad, const Scene& scene, std::span<const std::uint32_t> moving)
{
    if (broad.size() > 0) return broad.move(moving);
    std::vector<std::uint32_t> resting = all_bodies(scene);
    std::erase_if(resting, [&](std::uint32_t body) { return !scene.is_static[body]; });
    broad.add(resting, true), broad.add(moving);
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
    DelimitationStage(const Scene& scene, const Settings& settings, BroadPhase& tree)
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
        add_or_move(tree_, scene, moving_);
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
    BroadPhase& tree_;
    std::vector<std::uint32_t> all_, moving_;
    bool lists_survivors_; ///< the kd-tree goes on with the regions themselves
};

std::unique_ptr<BroadPhase> make(BroadPhaseKind kind, const BroadPhase::Options& options)
{
    switch (kind) {
    case BroadPhaseKind::kd_tree:
        break;
    case BroadPhaseKind::octree:
        return make_octree(options);
    case BroadPhaseKind::brute_force:
        return make_brute_force(options);
    }
    return make_kd_tree(options);
}

class BroadStage final : public Stage {
public:
    BroadStage(const Scene& scene, BroadPhaseKind kind, BroadPhase& tree)
        : tree_(tree), kind_(kind), moving_(moving_bodies(scene))
    {
    }
    std::string_view name() const override { return "broad"; }
    std::string_view unit() const override { return "pairs"; }

    void run(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        const BodyColumns columns{frame.boxes, scene.layers, scene.masks};
        const bool goes_on = kind_ == BroadPhaseKind::kd_tree && frame.delimited; // with what delimitation left
        if (!goes_on) {
            if (!own_) own_ = make(kind_, {.margin = frame.settings->clearance, .threads = frame.threads});
            add_or_move(*own_, scene, moving_);
        }
        const std::span<const BodyPair> pairs = goes_on ? tree_.find_pairs(columns) : own_->find_pairs(columns, true);
        frame.pairs.assign(pairs.begin(), pairs.end());
        // Those that move all survive: each is in its own region.
        stats.in = goes_on ? pairs_of(tree_.bodies_left(), moving_.size()) : pairs_of_survivors(scene, frame);
        stats.out = frame.pairs.size();
    }

    void skip(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        const BodyColumns columns{frame.boxes, scene.layers, scene.masks};
        frame.pairs.clear();
        for (std::size_t i = 0; i < frame.survivors.size(); ++i)
            for (std::size_t j = i + 1; j < frame.survivors.size(); ++j) {
                const std::uint32_t a = frame.survivors[i], b = frame.survivors[j];
                if (!(scene.is_static[a] && scene.is_static[b]) && columns.allows(a, b)) frame.pairs.push_back({a, b});
            }
        stats.in = pairs_of_survivors(scene, frame);
        stats.out = frame.pairs.size();
    }

private:
    /// Pairs of `bodies`, of which so many move, that are not both static.
    static std::uint64_t pairs_of(std::uint64_t bodies, std::uint64_t moving)
    {
        const auto pairs = [](std::uint64_t n) { return n * (n - (n > 0)) / 2; };
        return pairs(bodies) - pairs(bodies - std::min(moving, bodies));
    }
    static std::uint64_t pairs_of_survivors(const Scene& scene, const Frame& frame)
    {
        std::uint64_t moving = 0;
        for (std::uint32_t body : frame.survivors) moving += !scene.is_static[body];
        return pairs_of(frame.survivors.size(), moving);
    }

    BroadPhase& tree_;
    BroadPhaseKind kind_;
    std::vector<std::uint32_t> moving_;
    std::unique_ptr<BroadPhase> own_; ///< where the tree cannot be gone on with
};

} // namespace

std::unique_ptr<Stage> make_bounds_stage(const Scene& scene)
{
    return std::make_unique<BoundsStage>(scene);
}
std::unique_ptr<Stage> make_delimitation_stage(const Scene& scene, const Settings& settings, BroadPhase& tree)
{
    return std::make_unique<DelimitationStage>(scene, settings, tree);
}
std::unique_ptr<Stage> make_broad_stage(const Scene& scene, BroadPhaseKind kind, BroadPhase& tree)
{
    return std::make_unique<BroadStage>(scene, kind, tree);
}

} // namespace oncollide
