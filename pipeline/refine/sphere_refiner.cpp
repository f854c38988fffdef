#include <oncollide/pipeline/refine/sphere_refiner.hpp>

#include <algorithm>

#include <oncollide/base/threads/parallel.hpp>

namespace oncollide {

WalkPair SphereRefiner::pair_of(std::uint32_t pair) const
{
    const PairTask& task = tasks_[pair];
    return {task.a->spheres(),
            task.b->spheres(),
            task.a->number(),
            task.b->number(),
            depths_[pair][0],
            depths_[pair][1],
            task.pose_a,
            task.pose_b,
            context_->settings.clearance,
            cache_ ? (*cache_)[task.number].leaves : LeafPair{}};
}

void SphereRefiner::settle(std::uint32_t pair, const WalkResult& walk)
{
    const PairTask& task = tasks_[pair];
    const bool touching = walk.status == WalkStatus::touching;
    Verdict verdict = walk.status == WalkStatus::separate ? Verdict::separate : Verdict::undecided;
    // The deepest level and the rounding of floats limit the error that spheres reach.
    const Settings& settings = context_->settings;
    if (touching && (settings.depth || walk.bound <= settings.clearance + models_.max_error(*task.a, *task.b)))
        verdict = Verdict::within;
    if (cache_) (*cache_)[task.number].leaves = touching ? walk.leaves : LeafPair{};
    results_[pair] = {verdict, ContactKind::unknown, walk.bound};
}

void SphereRefiner::refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                           std::span<Finding> results)
{
    context_ = &context, tasks_ = tasks, results_ = results;
    cache_ = context.settings.coherence ? cache : nullptr;
    give_up_ = false, started_ = 0, again_.clear();
    depths_.clear();
    {
        const auto lock = context.walking();
        for (const PairTask& task : tasks) {
            const double error = models_.max_error(*task.a, *task.b);
            const auto depth = [&](const Model& m) { return std::min(models_.depth(m, error), m.spheres()->depth()); };
            depths_.push_back({depth(*task.a), depth(*task.b)});
        }
    }
    const std::size_t budget = context.settings.memory_budget;
    parked_room_ = (budget ? std::clamp(budget / 4, least_parked_bytes, most_parked_bytes) : most_parked_bytes) /
                   Walker::bytes_per_parked;
    const auto threads = static_cast<std::size_t>(std::max(context.threads, 1));
    for (auto* side : {&workers_, &parked_workers_})
        while (side->size() < threads) side->emplace_back();
    run_rounds();
    count();
}

void SphereRefiner::run_rounds()
{
    const std::size_t all = tasks_.size();
    slice_size_ = all < pairs_worth_slices ? all : std::clamp<std::size_t>(all / slices, 1, most_in_slice);
    const auto start_slice = [&] {
        next_slice();
        const auto lock = context_->walking();
        walk_slice();
    };
    start_slice();
    bool grown = false; // the first slice has found all of its cells
    while (!context_->stopped()) {
        if (!gather_parked()) {
            if (started_ == all && again_.empty()) break;
            grown = true;
            start_slice();
            continue;
        }
        grow_trees([&] {
            if (!grown || parked_entries_ > parked_room_ / 2) return;
            next_slice();
            walk_slice();
        });
        resume_all();
    }
}

/// Postponed pairs come first.
void SphereRefiner::next_slice()
{
    const auto back = again_.begin() + static_cast<std::ptrdiff_t>(std::min(slice_size_, again_.size()));
    slice_.assign(again_.begin(), back);
    again_.erase(again_.begin(), back);
    while (slice_.size() < slice_size_ && started_ < tasks_.size())
        slice_.push_back(static_cast<std::uint32_t>(started_++));
}

/// Expands the cells that parked traversals need in one batch; calls `meanwhile` while the backend works.
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

void SphereRefiner::walk_slice()
{
    parallel_chunks(slice_.size(), pairs_per_chunk, context_->threads, [&](std::size_t begin, std::size_t end, int t) {
        Worker& worker = workers_[static_cast<std::size_t>(t)];
        for (std::size_t i = begin; i < end; ++i) {
            if (i % pairs_per_look == 0 && context_->stopped()) return;
            const std::uint32_t pair = slice_[i];
            ParkedWork work;
            const WalkResult found = worker.walker.start(pair_of(pair), context_->frame, work);
            if (work.count)
                worker.parked.push_back({pair, static_cast<std::uint32_t>(t), 0, found, work});
            else
                settle(pair, found);
        }
    });
}

/// Merges the threads' parked traversals in the order of pairs, and prepares the workers for the next round. Postpones
/// traversals beyond the memory bound.
bool SphereRefiner::gather_parked()
{
    workers_.swap(parked_workers_);
    parked_.clear();
    for (Worker& worker : parked_workers_) {
        parked_.insert(parked_.end(), worker.parked.begin(), worker.parked.end());
        worker.parked.clear();
    }
    std::sort(parked_.begin(), parked_.end(), [](const Parked& x, const Parked& y) { return x.pair < y.pair; });
    for (Worker& worker : workers_) worker.walker.clear();
    parked_entries_ = 0;
    std::size_t kept = 0;
    while (kept < parked_.size() && (kept == 0 || parked_entries_ + parked_[kept].work.count <= parked_room_))
        parked_entries_ += parked_[kept++].work.count;
    if (kept < parked_.size()) {
        for (std::size_t i = kept; i < parked_.size(); ++i) again_.push_back(parked_[i].pair);
        std::sort(again_.begin(), again_.end());
        parked_.resize(kept);
        slice_size_ = std::min(slice_size_, kept); // the number of traversals that fit
    }
    return !parked_.empty();
}

void SphereRefiner::gather_requests()
{
    requests_.clear();
    for (const Parked& p : parked_) parked_workers_[p.worker].walker.requests(pair_of(p.pair), p.work, requests_);
    std::sort(requests_.begin(), requests_.end());
    requests_.erase(std::unique(requests_.begin(), requests_.end()), requests_.end());
}

void SphereRefiner::resume_all()
{
    const auto lock = context_->walking();
    parallel_chunks(parked_.size(), pairs_per_chunk, context_->threads, [&](std::size_t begin, std::size_t end, int t) {
        Worker& worker = workers_[static_cast<std::size_t>(t)];
        for (std::size_t i = begin; i < end; ++i) {
            if (i % pairs_per_look == 0 && context_->stopped()) return;
            const Parked& p = parked_[i];
            ParkedWork work = p.work;
            const WalkResult found =
                worker.walker.resume(pair_of(p.pair), context_->frame, parked_workers_[p.worker].walker, p.found,
                                     p.resumed + 1, give_up_, work);
            if (work.count)
                worker.parked.push_back({p.pair, static_cast<std::uint32_t>(t), p.resumed + 1, found, work});
            else
                settle(p.pair, found);
        }
    });
}

void SphereRefiner::count()
{
    for (auto* side : {&workers_, &parked_workers_})
        for (Worker& worker : *side) {
            worker.walker.clear(), worker.parked.clear(); // left over by a call that was stopped
            context_->trees.node_pairs += worker.walker.node_pairs();
            worker.walker.reset_counters();
        }
}

} // namespace oncollide
