#include <algorithm>

#include <oncollide/base/parallel.hpp>
#include <oncollide/narrowphase/exact/exact_fcl.hpp>
#include <oncollide/pipeline/containment_test.hpp>
#include <oncollide/pipeline/exact_stages.hpp>

namespace oncollide {

namespace {

/// Asks FCL about every pair that the sphere-trees left over.
///
/// Surfaces that cross in one frame mostly cross in the same place in the next. So the stage remembers the two cells of
/// the trees in which two triangles met, and tries FCL's triangle test on the triangles of these cells first; only
/// where that finds nothing does FCL get the bodies whole. Either way it is FCL's triangle test that says "colliding",
/// and FCL's whole-body query that says "separate".
class FclStage final : public Stage {
public:
    FclStage(const Scene& scene, const Settings& settings, Forest& forest)
        : forest_(forest), fcl_(scene, settings.clearance), enclosures_(forest)
    {
    }
    std::string_view name() const override { return "exact"; }
    std::string_view unit() const override { return "pairs"; }
    std::string_view reason_to_skip(const Scene&, const Frame& frame) const override { return off_unless_asked(frame); }

    void run(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        find_open(frame);
        workers_.resize(static_cast<std::size_t>(std::max(frame.threads, 1)));
        read_triangles(scene);
        for_each(frame, [&](Open& open, PairResult& result, Worker& worker) {
            if (meets_again(scene, open, worker)) decide(result, Verdict::colliding, ContactKind::unknown, 0);
        });
        for (const Open& open : open_)
            if (frame.results[open.result].stage != stage_index)
                fcl_.prepare(scene.geometry[open.pair.a]), fcl_.prepare(scene.geometry[open.pair.b]);
        for_each(frame, [&](Open& open, PairResult& result, Worker&) {
            if (result.stage != stage_index) ask_whole(scene, open, result);
        });

        enclosures_.find(scene, frame, stage_index);
        stats.in = open_.size();
        for (const Open& open : open_) stats.out += frame.results[open.result].verdict != Verdict::separate;
        std::erase_if(open_, [](const Open& open) { return open.met.a == 0; });
        met_.swap(open_);
    }

    void skip(const Scene&, Frame& frame, StageStats& stats) override { pass_on(frame, stats); }

private:
    static constexpr std::uint8_t stage_index = exact_stage_index;
    static constexpr int levels_above_leaves = 2; ///< of the cells that are remembered: they hold some 20 triangles

    /// A pair without a verdict.
    struct Open {
        BodyPair pair;
        std::uint32_t result; ///< in frame.results
        LeafPair met;         ///< the cells in which triangles met last; 0: not known
        std::size_t cells;    ///< where these are in cells_, the one of a first
    };
    struct Worker {
        std::vector<Aabb> boxes;
    };

    /// Results and what was met last frame are sorted by pair: one pass.
    void find_open(const Frame& frame)
    {
        open_.clear();
        auto last = met_.begin();
        for (std::uint32_t i = 0; i < frame.results.size(); ++i) {
            const PairResult& result = frame.results[i];
            if (!open(result)) continue;
            const BodyPair pair{index(result.a), index(result.b)};
            while (last != met_.end() && last->pair < pair) ++last;
            const bool known = last != met_.end() && last->pair == pair;
            open_.push_back({pair, i, known ? last->met : LeafPair{}, 0});
        }
    }

    /// The triangles of all remembered cells, in one go: a GPU backend has them far away.
    void read_triangles(const Scene& scene)
    {
        cells_.clear(), triangles_.clear(), ends_.clear();
        for (Open& open : open_) {
            if (!open.met.a) continue;
            open.cells = cells_.size();
            cells_.push_back({scene.geometry[open.pair.a], open.met.a});
            cells_.push_back({scene.geometry[open.pair.b], open.met.b});
        }
        forest_.triangles(cells_, triangles_, ends_);
    }

    template <class Work>
    void for_each(Frame& frame, Work work)
    {
        parallel_chunks(open_.size(), 32, frame.threads, [&](std::size_t begin, std::size_t end, int thread) {
            for (std::size_t i = begin; i < end; ++i)
                work(open_[i], frame.results[open_[i].result], workers_[static_cast<std::size_t>(thread)]);
        });
    }

    static void decide(PairResult& result, Verdict verdict, ContactKind kind, double bound)
    {
        result.verdict = verdict, result.kind = kind, result.bound = bound, result.stage = stage_index;
    }

    bool meets_again(const Scene& scene, Open& open, Worker& worker)
    {
        if (!open.met.a) return false;
        const auto [a, b] = open.pair;
        const auto list = [&](std::size_t cell) {
            const std::size_t begin = cell ? ends_[cell - 1] : 0;
            return std::span<const std::uint32_t>(triangles_).subspan(begin, ends_[cell] - begin);
        };
        if (fcl_.triangles_meet(scene, a, b, list(open.cells), list(open.cells + 1), worker.boxes)) return true;
        open.met = {};
        return false;
    }

    void ask_whole(const Scene& scene, Open& open, PairResult& result)
    {
        const auto [a, b] = open.pair;
        const ExactFcl::Answer answer = fcl_.answer(scene, a, b);
        decide(result, answer.verdict, answer.verdict == Verdict::within ? ContactKind::near : ContactKind::unknown,
               answer.bound);
        if (answer.triangle_a >= 0) open.met = cells_of(scene, a, b, answer);
    }

    /// The cells around the middle of where the boxes of the two triangles overlap.
    LeafPair cells_of(const Scene& scene, std::uint32_t a, std::uint32_t b, const ExactFcl::Answer& answer)
    {
        const Eigen::Isometry3d b_to_a = scene.poses[a].inverse(Eigen::Isometry) * scene.poses[b];
        const auto box_of = [&](std::uint32_t body, int triangle, const Eigen::Isometry3d& to) {
            const Mesh& mesh = std::get<Mesh>(scene.geometries[index(scene.geometry[body])].data);
            Aabb box;
            for (std::uint32_t v : mesh.triangles[static_cast<std::size_t>(triangle)]) box.add(to * mesh.vertices[v]);
            return box;
        };
        const Aabb box_a = box_of(a, answer.triangle_a, Eigen::Isometry3d::Identity());
        const Aabb box_b = box_of(b, answer.triangle_b, b_to_a);
        const Eigen::Vector3d middle = 0.5 * (box_a.min.cwiseMax(box_b.min) + box_a.max.cwiseMin(box_b.max));
        return {forest_.cell_at(scene.geometry[a], middle, levels_above_leaves),
                forest_.cell_at(scene.geometry[b], b_to_a.inverse(Eigen::Isometry) * middle, levels_above_leaves)};
    }

    Forest& forest_;
    ExactFcl fcl_;
    ContainmentTest enclosures_;
    std::vector<Open> open_, met_; ///< this frame's open pairs; last frame's that met, sorted by pair
    std::vector<Worker> workers_;
    std::vector<Forest::CellTriangles> cells_;
    std::vector<std::uint32_t> triangles_; ///< of cells_, one after the other
    std::vector<std::size_t> ends_;        ///< by cell: where its triangles end
};

} // namespace

std::unique_ptr<Stage> make_fcl_stage(const Scene& scene, const Settings& settings, Forest& forest)
{
    return std::make_unique<FclStage>(scene, settings, forest);
}

} // namespace oncollide
