#include <oncollide/pipeline/pair_walks.hpp>

#include <algorithm>

#include <oncollide/base/parallel.hpp>

namespace oncollide {

void PairWalks::run(const Scene& scene, Frame& frame, std::span<Walk> walks)
{
    scene_ = &scene, frame_ = &frame, walks_ = walks;
    give_up_ = false;
    const auto threads = static_cast<std::size_t>(std::max(frame.threads, 1));
    for (auto* side : {&workers_, &parked_workers_})
        while (side->size() < threads) side->emplace_back();
    for (const Walk& walk : walks) // trees are made here, in order: walks run side by side
        forest_.tree(scene.geometry[walk.pair.a]), forest_.tree(scene.geometry[walk.pair.b]);
    run_rounds();
    count();
}

WalkPair PairWalks::pair_of(const Walk& walk)
{
    return forest_.walk_pair(*scene_, walk.pair.a, walk.pair.b, walk.hint);
}

void PairWalks::run_rounds()
{
    const std::size_t count = walks_.size();
    std::size_t walked = 0, slice = count < pairs_worth_slices ? count : std::max<std::size_t>(count / slices, 1);
    const auto walk_slice = [&] {
        const std::size_t end = std::min(walked + slice, count);
        walk(walked, end);
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
        gather_requests();
        Round round{.submitted_ms = frame_->clock_ms()};
        const std::uint64_t refused = forest_.submit(requests_, frame_->threads);
        if (grown) walk_slice();
        round.waited_ms = frame_->clock_ms();
        round.work = forest_.grow(frame_->number);
        round.done_ms = frame_->clock_ms();
        round.rows = requests_.size() - refused;
        frame_->rounds.push_back(round);
        frame_->trees.refused += refused;
        give_up_ |= refused > 0;
        resume_all();
    }
}

void PairWalks::walk(std::size_t first, std::size_t last)
{
    parallel_chunks(last - first, pairs_a_chunk, frame_->threads, [&](std::size_t begin, std::size_t end, int t) {
        Worker& worker = workers_[static_cast<std::size_t>(t)];
        for (std::size_t i = first + begin; i < first + end; ++i) {
            ParkedWork work;
            walks_[i].result = worker.walker.start(pair_of(walks_[i]), frame_->number, forest_.backend(), work);
            if (work.count)
                worker.parked.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(t), 0, work});
        }
    });
}

/// Joins the threads' parked walks in the order of the pairs, and makes room for the next round's.
bool PairWalks::gather_parked()
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

void PairWalks::gather_requests()
{
    requests_.clear();
    for (const Parked& p : parked_)
        parked_workers_[p.worker].walker.requests(pair_of(walks_[p.walk]), p.work, requests_);
    std::sort(requests_.begin(), requests_.end());
    requests_.erase(std::unique(requests_.begin(), requests_.end()), requests_.end());
}

void PairWalks::resume_all()
{
    parallel_chunks(parked_.size(), pairs_a_chunk, frame_->threads, [&](std::size_t begin, std::size_t end, int t) {
        Worker& worker = workers_[static_cast<std::size_t>(t)];
        for (std::size_t i = begin; i < end; ++i) {
            const Parked& p = parked_[i];
            ParkedWork work = p.work;
            WalkResult& result = walks_[p.walk].result;
            result = worker.walker.resume(pair_of(walks_[p.walk]), frame_->number, forest_.backend(),
                                          parked_workers_[p.worker].walker, result, p.resumed + 1, give_up_, work);
            if (work.count) worker.parked.push_back({p.walk, static_cast<std::uint32_t>(t), p.resumed + 1, work});
        }
    });
}

void PairWalks::count()
{
    for (auto* side : {&workers_, &parked_workers_})
        for (Worker& worker : *side) {
            worker.walker.clear();
            frame_->trees.node_pairs += worker.walker.node_pairs();
            worker.walker.reset_counters();
        }
}

} // namespace oncollide
