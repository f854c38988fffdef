#include <oncollide/pipeline/world/frame_manifolds.hpp>

#include <algorithm>
#include <utility>

#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/pairs/manifold_tests.hpp>
#include <oncollide/pipeline/world/query_worker.hpp>

namespace oncollide {

/// Sets which pairs are copied, and which are measured.
void FrameManifoldCache::choose_pairs(WorldImpl& world, const ManifoldOptions& options, bool reuse)
{
    const Frame& frame = world.frame;
    const std::size_t count = frame.results.size();
    kept_from_.assign(count, none), open_.clear();
    std::size_t sweep = 0, next = 0; // next: the first pair that was not looked at
    const auto look = [&](std::size_t end) {
        for (; next < end; ++next) {
            while (sweep < frame.sweeps.size() && frame.sweeps[sweep].pair < next) ++sweep;
            const bool swept = sweep < frame.sweeps.size() && frame.sweeps[sweep].pair == next;
            const PairResult& result = frame.results[next];
            if (swept || result.verdict != Verdict::separate ||
                (options.margin > 0 && result.bound <= options.margin) ||
                may_be_enclosed(world.task_of(result.a, result.b)))
                open_.push_back(static_cast<std::uint32_t>(next));
        }
    };
    if (reuse)
        for (const PairRun& run : frame.cache.unchanged()) {
            look(run.now);
            for (std::uint32_t k = 0; k < run.count; ++k) kept_from_[next++] = last_.place[run.before + k];
        }
    look(count);
}

/// Makes the tasks of the open pairs, and the trees that they need.
void FrameManifoldCache::make_tasks(WorldImpl& world)
{
    tasks_.clear(), of_trees_.clear();
    for (const std::uint32_t i : open_) {
        const PairResult& pair = world.frame.results[i];
        tasks_.push_back(world.task_of(pair.a, pair.b));
        if (needs_trees(tasks_.back())) of_trees_.push_back(tasks_.back());
    }
    if (!of_trees_.empty()) world.need_trees(of_trees_);
}

/// Measures the open pairs, and joins them with the copied ones in the order of the pairs.
void FrameManifoldCache::measure(WorldImpl& world, const ManifoldOptions& options)
{
    const std::size_t count = world.frame.results.size();
    now_.manifolds.pairs.clear(), now_.place.assign(count, none);
    const ExecutorScope scope(world.settings.executor);
    join_.begin(now_.manifolds, world.frame.context.threads);
    const auto add = [&](std::size_t pair, const StoredManifold& found) {
        now_.place[pair] = static_cast<std::uint32_t>(now_.manifolds.pairs.size());
        now_.manifolds.pairs.push_back({world.frame.results[pair].a, world.frame.results[pair].b});
        join_.add(found);
    };
    std::size_t next = 0;
    const auto copy_until = [&](std::size_t end) {
        for (; next < end; ++next)
            if (kept_from_[next] != none) add(next, {last_.manifolds, kept_from_[next]});
    };
    world.manifolds(tasks_, options, join_, [&](std::size_t i, const StoredManifold& found) {
        copy_until(open_[i]);
        if (found.is_listed()) add(open_[i], found);
    });
    copy_until(count);
    join_.end();
}

/// Limits the points of all pairs together.
const FrameManifolds& FrameManifoldCache::limited(const ManifoldOptions& options)
{
    if (options.points_in_all == 0 || now_.manifolds.points.size() <= options.points_in_all) return now_.manifolds;
    limited_.pairs = now_.manifolds.pairs;
    limit_points(now_.manifolds, options.points_in_all, limited_);
    return limited_;
}

const FrameManifolds& FrameManifoldCache::find(WorldImpl& world, const ManifoldOptions& options)
{
    if (world.frame.number == 0)
        throw Error(ErrorKind::usage, "manifolds: there was no frame; call World::step() first");
    if (world.changed_since_step)
        throw Error(ErrorKind::usage,
                    "manifolds: bodies or models changed since the last frame; call World::step() first");
    const std::uint32_t frame = world.frame.number - 1;
    const bool same = frame_ && options_ == options;
    if (same && *frame_ == frame) return limited(options);
    const bool reuse = same && *frame_ + 1 == frame;
    std::swap(now_, last_);
    frame_.reset(); // unless all is found
    choose_pairs(world, options, reuse);
    if (std::ranges::all_of(kept_from_, [](std::uint32_t place) { return place == none; }))
        std::swap(now_, last_); // the memory that was written last is in the caches
    make_tasks(world);
    measure(world, options);
    frame_ = frame, options_ = options;
    return limited(options);
}

std::size_t FrameManifoldCache::bytes() const
{
    const auto of = [](const auto&... lists) { return (... + (lists.capacity() * sizeof(lists[0]))); };
    std::size_t sum = of(kept_from_, open_, tasks_, of_trees_) + join_.bytes();
    for (const Lists* lists : {&now_, &last_})
        sum += bytes_of(lists->manifolds) + of(lists->manifolds.pairs, lists->place);
    return sum + bytes_of(limited_) + of(limited_.pairs);
}

} // namespace oncollide
