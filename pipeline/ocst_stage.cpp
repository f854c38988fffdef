#include <algorithm>

#include <oncollide/narrowphase/solid.hpp>
#include <oncollide/pipeline/forest.hpp>
#include <oncollide/pipeline/stage.hpp>
#include <oncollide/scenes/parallel.hpp>

namespace oncollide {

namespace {

/// Walks every candidate pair, in rounds:
///
///     pairs walk ──> parked ──> requests ──> one batch ──> trees grow ──> parked pairs walk on ──> ...
///                                              └─ meanwhile the next pairs start to walk
///
/// until none is parked. Many pairs start in slices, one a round: while a GPU answers, the CPU has walks to start, and
/// later slices find most of their cells grown by earlier ones, which keeps what is parked small. The number of slices
/// is bounded, so rounds do not grow with the number of pairs.
class OcstStage final : public Stage {
public:
    OcstStage(const Scene& scene, const Settings& settings, Forest& forest) : forest_(forest)
    {
        if (settings.mode == Mode::solid) solid_.emplace(scene);
    }
    std::string_view name() const override { return "ocst"; }
    std::string_view unit() const override { return "pairs"; }

    void run(const Scene& scene, Frame& frame, StageStats& stats) override
    {
        const std::size_t count = frame.pairs.size();
        frame.trees = {}, frame.rounds.clear();
        stats.in = count;
        walks_.resize(count);
        const auto threads = static_cast<std::size_t>(std::max(frame.threads, 1));
        for (auto* side : {&workers_, &parked_workers_})
            while (side->size() < threads) side->emplace_back();

        for (BodyPair pair : frame.pairs) // trees are made here, in order: walks run side by side
            forest_.tree(scene.geometry[pair.a]), forest_.tree(scene.geometry[pair.b]);
        find_hints(frame);
        give_up_ = false;
        run_rounds(scene, frame);
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
            // Both bodies have points in the box around the two.
            frame.results[i] = {BodyId{pair.a}, BodyId{pair.b}, Verdict::undecided, stage_index, both.diagonal()};
        }
        stats.in = stats.out = stats.undecided = frame.pairs.size();
    }

    static constexpr std::uint8_t stage_index = 3;

private:
    struct Walk {
        WalkResult result;
        LeafPair hint;
    };
    struct Parked {
        std::uint32_t pair, worker;
        int resumed;     ///< times that the pair was taken up again
        ParkedWork work; ///< in the worker's walker
    };
    struct Worker {
        Walker walker;
        std::vector<Parked> parked;
    };
    struct Decided {
        BodyPair pair;
        LeafPair leaves;
    };

    WalkPair pair_of(const Scene& scene, const Frame& frame, std::size_t i)
    {
        return forest_.walk_pair(scene, frame.pairs[i].a, frame.pairs[i].b, walks_[i].hint);
    }

    /// Both lists are sorted by pair: one pass.
    void find_hints(const Frame& frame)
    {
        auto last = decided_.begin();
        for (std::size_t i = 0; i < frame.pairs.size(); ++i) {
            while (last != decided_.end() && last->pair < frame.pairs[i]) ++last;
            const bool known = last != decided_.end() && last->pair == frame.pairs[i];
            walks_[i].hint = known ? last->leaves : LeafPair{};
        }
    }

    void run_rounds(const Scene& scene, Frame& frame)
    {
        const std::size_t count = frame.pairs.size();
        std::size_t walked = 0, slice = count < pairs_worth_slices ? count : std::max<std::size_t>(count / slices, 1);
        const auto walk_slice = [&] {
            const std::size_t end = std::min(walked + slice, count);
            walk(scene, frame, walked, end);
            walked = end;
        };
        walk_slice();
        bool grown = false; // the first slice has found all of its cells
        while (true) {
            if (!gather_parked()) {
                if (walked == count) break;
                grown = true;
                walk_slice();
                continue;
            }
            gather_requests(scene, frame);
            Round round{.submitted_ms = frame.clock_ms()};
            const std::uint64_t refused = forest_.submit(requests_, frame.threads);
            if (grown) walk_slice();
            round.waited_ms = frame.clock_ms();
            round.work = forest_.grow(frame.number);
            round.done_ms = frame.clock_ms();
            round.rows = requests_.size() - refused;
            frame.rounds.push_back(round);
            frame.trees.refused += refused;
            give_up_ |= refused > 0;
            resume_all(scene, frame);
        }
    }

    void walk(const Scene& scene, const Frame& frame, std::size_t first, std::size_t last)
    {
        parallel_chunks(last - first, pairs_a_chunk, frame.threads, [&](std::size_t begin, std::size_t end, int t) {
            Worker& worker = workers_[static_cast<std::size_t>(t)];
            for (std::size_t i = first + begin; i < first + end; ++i) {
                ParkedWork work;
                walks_[i].result = worker.walker.start(pair_of(scene, frame, i), frame.number, forest_.backend(), work);
                if (work.count)
                    worker.parked.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(t), 0, work});
            }
        });
    }

    /// Joins the threads' parked walks in the order of the pairs, and makes room for the next round's.
    bool gather_parked()
    {
        workers_.swap(parked_workers_);
        parked_.clear();
        for (Worker& worker : parked_workers_) {
            parked_.insert(parked_.end(), worker.parked.begin(), worker.parked.end());
            worker.parked.clear();
        }
        std::sort(parked_.begin(), parked_.end(), [](const Parked& x, const Parked& y) { return x.pair < y.pair; });
        for (Worker& worker : workers_) worker.walker.clear();
        return !parked_.empty();
    }

    void gather_requests(const Scene& scene, const Frame& frame)
    {
        requests_.clear();
        for (const Parked& p : parked_)
            parked_workers_[p.worker].walker.requests(pair_of(scene, frame, p.pair), p.work, requests_);
        std::sort(requests_.begin(), requests_.end());
        requests_.erase(std::unique(requests_.begin(), requests_.end()), requests_.end());
    }

    void resume_all(const Scene& scene, const Frame& frame)
    {
        parallel_chunks(parked_.size(), pairs_a_chunk, frame.threads, [&](std::size_t begin, std::size_t end, int t) {
            Worker& worker = workers_[static_cast<std::size_t>(t)];
            for (std::size_t i = begin; i < end; ++i) {
                const Parked& p = parked_[i];
                ParkedWork work = p.work;
                WalkResult& result = walks_[p.pair].result;
                result = worker.walker.resume(pair_of(scene, frame, p.pair), frame.number, forest_.backend(),
                                              parked_workers_[p.worker].walker, result, p.resumed + 1, give_up_, work);
                if (work.count) worker.parked.push_back({p.pair, static_cast<std::uint32_t>(t), p.resumed + 1, work});
            }
        });
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
        for (auto* side : {&workers_, &parked_workers_})
            for (Worker& worker : *side) {
                worker.walker.clear();
                frame.trees.node_pairs += worker.walker.node_pairs();
                worker.walker.reset_counters();
            }
    }

    static constexpr std::size_t pairs_a_chunk = 256;
    static constexpr std::size_t pairs_worth_slices = 1024, slices = 8;

    Forest& forest_;
    std::optional<SolidTest> solid_;
    std::vector<Walk> walks_; ///< by pair
    std::vector<Worker> workers_, parked_workers_;
    std::vector<Parked> parked_;
    std::vector<CellRequest> requests_;
    std::vector<Decided> decided_; ///< last frame's touching pairs and the leaves that showed it
    bool give_up_ = false;
};

} // namespace

std::unique_ptr<Stage> make_ocst_stage(const Scene& scene, const Settings& settings, Forest& forest)
{
    return std::make_unique<OcstStage>(scene, settings, forest);
}

} // namespace oncollide
