// The stages that decide pairs: refine, exact.
#include <algorithm>
#include <atomic>
#include <iterator>
#include <span>
#include <utility>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/pipeline/refine/narrowing.hpp>
#include <oncollide/pipeline/world/stage.hpp>

namespace oncollide {

namespace {

constexpr std::size_t results_at_once = 1024;

/// The result of a pair of which only the boxes are known.
PairResult undecided(const BodyTable& bodies, BodyPair pair)
{
    return {{Verdict::undecided, ContactKind::unknown, farthest_apart(bodies.boxes()[pair.a], bodies.boxes()[pair.b])},
            StageId::refine,
            bodies.id(pair.a),
            bodies.id(pair.b)};
}

/// Runs one level on some of the frame's results and updates them.
class LevelRun {
public:
    LevelRun(const Settings& settings, ModelStore& models, GpuPairs* gpu, Level level, StageId stage)
        : level_(settings, models, level, gpu), stage_(stage)
    {
    }

    /// Decides the open pairs whose result `wanted` selects. Without coherence it also tests pairs at rest, without
    /// their memory, which must stay as if they had not been tested.
    void run(const BodyTable& bodies, Frame& frame, StageStats& stats, auto wanted)
    {
        const std::size_t rounds = frame.context.rounds.size();
        decide(bodies, frame, frame.open, &frame.cache, stats, wanted);
        if (!frame.retested.empty()) decide(bodies, frame, frame.retested, nullptr, stats, wanted);
        for (const Round& round : std::span(frame.context.rounds).subspan(rounds))
            stats.gpu_ms += round.gpu_ms, stats.wait_ms += round.wait_ms;
    }

private:
    void decide(const BodyTable& bodies, Frame& frame, std::span<const std::uint32_t> pairs, PairCache* cache,
                StageStats& stats, auto wanted)
    {
        if (leaves_all(bodies, frame, pairs)) {
            stats.in += pairs.size(), stats.out += pairs.size();
            return;
        }
        wanted_.clear();
        std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(wanted_),
                     [&](std::uint32_t i) { return wanted(frame.results[i]); });
        tasks_.resize(wanted_.size()), refined_.resize(wanted_.size());
        parallel_chunks(wanted_.size(), results_at_once, frame.context.threads,
                        [&](std::size_t begin, std::size_t end, int) {
                            for (std::size_t i = begin; i < end; ++i)
                                tasks_[i] = task_of(bodies, frame.results[wanted_[i]], wanted_[i]),
                                refined_[i] = frame.results[wanted_[i]];
                        });
        level_.run(frame.context, tasks_, cache, refined_);
        stats.in += tasks_.size();
        std::atomic<std::size_t> undecided{0}, out{0};
        parallel_chunks(tasks_.size(), results_at_once, frame.context.threads,
                        [&](std::size_t begin, std::size_t end, int) {
                            std::size_t undecided_here = 0, out_here = 0;
                            for (std::size_t i = begin; i < end; ++i) {
                                PairResult& result = frame.results[tasks_[i].number];
                                const Finding& refined = refined_[i];
                                static_cast<Finding&>(result) = refined;
                                if (level_.decided(i)) {
                                    result.stage = stage_;
                                    undecided_here += refined.verdict == Verdict::undecided;
                                }
                                out_here += refined.verdict != Verdict::separate;
                            }
                            undecided += undecided_here, out += out_here;
                        });
        stats.undecided += undecided, stats.out += out;
    }
    /// True if the level would leave these pairs, of which only the boxes are known, to the exact level.
    bool leaves_all(const BodyTable& bodies, const Frame& frame, std::span<const std::uint32_t> pairs) const
    {
        return level_.leaves_to_exact() && std::ranges::all_of(pairs, [&](std::uint32_t i) {
                   return level_.there(bodies.model(frame.pairs[i].a), bodies.model(frame.pairs[i].b));
               });
    }
    static PairTask task_of(const BodyTable& bodies, const PairResult& result, std::uint32_t number)
    {
        const std::uint32_t a = result.a.slot, b = result.b.slot;
        return {number,
                &bodies.model(a),
                &bodies.model(b),
                &bodies.pose(a),
                &bodies.pose(b),
                bodies.travel(a) + bodies.travel(b),
                bodies.stretch(a) + bodies.stretch(b)};
    }

    Narrowing level_;
    StageId stage_;
    std::vector<std::uint32_t> wanted_; ///< results, by number
    std::vector<PairTask> tasks_;       ///< for each of them
    std::vector<Finding> refined_;
};

/// Refines down to the requested error, with sphere-trees or the OBB trees of meshes. OBB trees lead on to triangles,
/// so if predicates decide, this stage passes such pairs on to the exact level.
class RefineStage final : public Stage {
public:
    RefineStage(const Settings& settings, ModelStore& models, GpuPairs* gpu)
        : level_(settings, models, gpu, Level::refine, StageId::refine)
    {
    }
    StageId id() const override { return StageId::refine; }
    std::string_view unit() const override { return "pairs"; }
    std::string_view reason_to_skip(const BodyTable&, const Frame& frame) const override
    {
        return frame.pairs.empty() ? no_candidates : std::string_view{};
    }

    void run(BodyTable& bodies, Frame& frame, StageStats& stats) override
    {
        begin(bodies, frame);
        level_.run(bodies, frame, stats, [](const PairResult&) { return true; });
        stats.in += frame.kept_counts.pairs + frame.swept.size();
        stats.out += frame.kept_counts.left_by_refine + frame.swept.size();
    }

    void skip(BodyTable& bodies, Frame& frame, StageStats& stats) override
    {
        begin(bodies, frame);
        stats.in = stats.out = stats.undecided = frame.pairs.size();
    }

private:
    /// Fills the results: a pair of which nothing changed gets its last result, any other pair a bound from the boxes.
    /// An undecided pair is tried again.
    static void begin(const BodyTable& bodies, Frame& frame)
    {
        frame.cache.begin_frame(frame.pairs, frame.changed.marks(), frame.fresh.marks());
        const bool ended = std::exchange(frame.ended, false);
        if (ended) frame.results.swap(frame.last_results);
        frame.results.clear(), frame.results.reserve(frame.pairs.size());
        frame.kept.clear(), frame.open.clear(), frame.retested.clear(), frame.kept_counts = {};
        const auto open_until = [&](std::uint32_t end) {
            for (auto i = static_cast<std::uint32_t>(frame.results.size()); i < end; ++i)
                frame.results.emplace_back(), frame.open.push_back(i);
        };
        if (ended)
            for (const PairRun& run : frame.cache.unchanged()) {
                open_until(run.now);
                if (!frame.settings.coherence && frame.keeps)
                    retest(frame, run);
                else if (frame.settings.coherence)
                    keep(bodies, frame, run);
            }
        open_until(static_cast<std::uint32_t>(frame.pairs.size()));
        bound(bodies, frame, frame.open), bound(bodies, frame, frame.retested);
        leave_to_sweeps(bodies, frame);
        frame.context.trees.kept = frame.kept_counts.pairs;
    }

    /// Without Frame::keeps, only pairs of bodies that are asleep or static keep their result.
    static void keep(const BodyTable& bodies, Frame& frame, PairRun run)
    {
        const PairResult* const last = frame.last_results.data() + run.before;
        const auto stays = [&](const PairResult& pair) {
            return pair.verdict != Verdict::undecided &&
                   (frame.keeps || (bodies.rests(pair.a.slot) && bodies.rests(pair.b.slot)));
        };
        for (std::uint32_t i = 0; i < run.count;) {
            const std::uint32_t begin = i;
            for (; i < run.count && stays(last[i]); ++i) frame.kept_counts.add(last[i]);
            frame.results.insert(frame.results.end(), last + begin, last + i);
            if (i > begin) frame.kept.push_back({run.now + begin, run.before + begin, i - begin});
            if (i < run.count) frame.results.emplace_back(), frame.open.push_back(run.now + i++);
        }
    }

    /// Handles pairs that met and of which a body moves on: the poses at time 0 decide them, not the last ones.
    static void leave_to_sweeps(const BodyTable& bodies, Frame& frame)
    {
        frame.swept.clear();
        if (!bodies.any_motion() || !frame.settings.coherence) return;
        std::erase_if(frame.open, [&](std::uint32_t i) {
            const BodyPair pair = frame.pairs[i];
            const bool moves = bodies.motion(pair.a) || bodies.motion(pair.b);
            if (!moves || !frame.cache[i].meets) return false;
            frame.swept.push_back(i);
            return true;
        });
    }

    static void retest(Frame& frame, PairRun run)
    {
        for (std::uint32_t i = 0; i < run.count; ++i) {
            const bool decided = frame.last_results[run.before + i].verdict != Verdict::undecided;
            (decided ? frame.retested : frame.open).push_back(run.now + i);
            frame.results.emplace_back();
        }
    }

    static void bound(const BodyTable& bodies, Frame& frame, std::span<const std::uint32_t> pairs)
    {
        constexpr std::size_t ahead = 8;
        parallel_chunks(pairs.size(), results_at_once, frame.context.threads,
                        [&](std::size_t begin, std::size_t end, int) {
                            for (std::size_t k = begin; k < end; ++k) {
                                if (k + ahead < pairs.size()) {
                                    const BodyPair later = frame.pairs[pairs[k + ahead]];
                                    bodies.prefetch(later.b);
                                    if (later.a != frame.pairs[pairs[k + ahead - 1]].a) bodies.prefetch(later.a);
                                }
                                frame.results[pairs[k]] = undecided(bodies, frame.pairs[pairs[k]]);
                            }
                        });
    }

    LevelRun level_;
};

/// Decides the remaining pairs: by predicates, or by FCL where FCL confirms the result.
class ExactStage final : public Stage {
public:
    ExactStage(const Settings& settings, ModelStore& models, GpuPairs* gpu)
        : level_(settings, models, gpu, Level::exact, StageId::exact)
    {
    }
    StageId id() const override { return StageId::exact; }
    std::string_view unit() const override { return "pairs"; }
    std::string_view reason_to_skip(const BodyTable&, const Frame& frame) const override
    {
        return frame.settings.exact == ExactLevel::off ? "off" : std::string_view{};
    }

    void run(BodyTable& bodies, Frame& frame, StageStats& stats) override
    {
        level_.run(bodies, frame, stats, [](const PairResult& result) { return is_open(result.verdict); });
        stats.in += frame.kept_counts.exact, stats.out += frame.kept_counts.left_by_exact;
    }

    void skip(BodyTable&, Frame& frame, StageStats& stats) override
    {
        for (const PairResult& result : frame.results) {
            stats.in += result.verdict != Verdict::separate;
            stats.undecided += result.verdict == Verdict::undecided;
        }
        stats.out = stats.in;
    }

private:
    LevelRun level_;
};

} // namespace

std::unique_ptr<Stage> make_refine_stage(const Settings& settings, ModelStore& models, GpuPairs* gpu)
{
    return std::make_unique<RefineStage>(settings, models, gpu);
}
std::unique_ptr<Stage> make_exact_stage(const Settings& settings, ModelStore& models, GpuPairs* gpu)
{
    return std::make_unique<ExactStage>(settings, models, gpu);
}

} // namespace oncollide
