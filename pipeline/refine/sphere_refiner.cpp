#include <oncollide/pipeline/refine/sphere_refiner.hpp>

#include <algorithm>

#include <oncollide/base/parallel.hpp>

namespace oncollide {

WalkPair SphereRefiner::pair_of(const PairTask& task, LeafPair hint) const
{
    return {task.a->spheres.get(),
            task.b->spheres.get(),
            task.a->number,
            task.b->number,
            task.pose_a,
            task.pose_b,
            context_->settings.clearance,
            hint};
}

void SphereRefiner::refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                           std::span<RefineResult> results)
{
    context_ = &context;
    give_up_ = false;
    const auto threads = static_cast<std::size_t>(std::max(context.threads, 1));
    for (auto* side : {&workers_, &parked_workers_})
        while (side->size() < threads) side->emplace_back();
    walks_.clear();
    for (const PairTask& task : tasks)
        walks_.push_back({pair_of(task, cache ? (*cache)[task.number].leaves : LeafPair{}), {}});
    run_rounds();
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        const WalkResult& walk = walks_[i].result;
        const Verdict verdict = walk.status == WalkStatus::touching   ? Verdict::within
                                : walk.status == WalkStatus::separate ? Verdict::separate
                                                                      : Verdict::undecided;
        if (cache) (*cache)[tasks[i].number].leaves = verdict == Verdict::within ? walk.leaves : LeafPair{};
        results[i] = {verdict, ContactKind::unknown, walk.bound};
    }
    count();
}

void SphereRefiner::run_rounds()
{
    const std::size_t count = walks_.size();
    std::size_t walked = 0, slice = count < pairs_worth_slices ? count : std::max<std::size_t>(count / slices, 1);
    const auto walk_slice = [&] {
        const std::size_t end = std::min(walked + slice, count);
        walk(walked, end);
        walked = end;
    };
    const auto start_slice = [&] {
        const auto lock = context_->walking();
        walk_slice();
    };
    start_slice();
    bool grown = false; // the first slice has found all of its cells
    while (true) {
        if (!gather_parked()) {
            if (walked == count) break;
            grown = true;
            start_slice();
            continue;
        }
        grow_trees([&] {
            if (grown) walk_slice();
        });
        resume_all();
    }
}

/// One batch of what parked walks wait for; does `meanwhile` while the backend works.
template <class Meanwhile>
void SphereRefiner::grow_trees(Meanwhile meanwhile)
{
    const auto lock = context_->changing();
    gather_requests();
    Round round;
    round.submitted_ms = context_->clock_ms();
    const std::uint64_t refused = models_.submit(requests_, context_->threads);
    meanwhile();
    round.waited_ms = context_->clock_ms();
    const BatchWork work = models_.grow(context_->frame);
    round.done_ms = context_->clock_ms();
    round.rows = requests_.size() - refused;
    round.gpu_ms = work.gpu_ms, round.wait_ms = work.wait_ms, round.bytes = work.bytes;
    context_->rounds.push_back(round);
    TreeStats& trees = context_->trees;
    ++trees.rounds, trees.rows += round.rows, trees.refused += refused;
    trees.queries += work.queries, trees.gpu_bytes += work.bytes, trees.repeats += work.repeats;
    give_up_ |= refused > 0;
}

void SphereRefiner::walk(std::size_t first, std::size_t last)
{
    parallel_chunks(last - first, pairs_per_chunk, context_->threads, [&](std::size_t begin, std::size_t end, int t) {
        Worker& worker = workers_[static_cast<std::size_t>(t)];
        for (std::size_t i = first + begin; i < first + end; ++i) {
            ParkedWork work;
            walks_[i].result = worker.walker.start(walks_[i].pair, context_->frame, work);
            if (work.count)
                worker.parked.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(t), 0, work});
        }
    });
}

/// Joins the threads' parked walks in the order of the pairs, and makes room for the next round's.
bool SphereRefiner::gather_parked()
{
    workers_.swap(parked_workers_);
    parked_.clear();
    for (Worker& worker : parked_workers_) {
        parked_.insert(parked_.end(), worker.parked.begin(), worker.parked.end());
        worker.parked.clear();
    }
    std::sort(parked_.begin(), parked_.end(), [](const Parked& x, const Parked& y) { return x.walk < y.walk; });
    for (Worker& worker : workers_) worker.walker.clear();
    return !parked_.empty();
}

void SphereRefiner::gather_requests()
{
    requests_.clear();
    for (const Parked& p : parked_) parked_workers_[p.worker].walker.requests(walks_[p.walk].pair, p.work, requests_);
    std::sort(requests_.begin(), requests_.end());
    requests_.erase(std::unique(requests_.begin(), requests_.end()), requests_.end());
}

void SphereRefiner::resume_all()
{
    const auto lock = context_->walking();
    parallel_chunks(parked_.size(), pairs_per_chunk, context_->threads, [&](std::size_t begin, std::size_t end, int t) {
        Worker& worker = workers_[static_cast<std::size_t>(t)];
        for (std::size_t i = begin; i < end; ++i) {
            const Parked& p = parked_[i];
            ParkedWork work = p.work;
            WalkResult& result = walks_[p.walk].result;
            result = worker.walker.resume(walks_[p.walk].pair, context_->frame, parked_workers_[p.worker].walker,
                                          result, p.resumed + 1, give_up_, work);
            if (work.count) worker.parked.push_back({p.walk, static_cast<std::uint32_t>(t), p.resumed + 1, work});
        }
    });
}

void SphereRefiner::count()
{
    for (auto* side : {&workers_, &parked_workers_})
        for (Worker& worker : *side) {
            worker.walker.clear();
            context_->trees.node_pairs += worker.walker.node_pairs();
            worker.walker.reset_counters();
        }
}

} // namespace oncollide
