// Working memory of const queries, and the loop that runs batches of them on the World's threads.
#pragma once
#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/simd/prefetch.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/narrowphase/rays/segment_query.hpp>
#include <oncollide/pipeline/world/world_impl.hpp>

namespace oncollide {

/// One query thread's working memory.
struct WorldImpl::QueryWorker {
    /// @param settings  the settings, kept by reference
    /// @param gpu  null: the CPU decides all pairs, on any thread
    QueryWorker(WorldImpl& impl, const Settings& settings, GpuPairs* gpu = nullptr);
    BothLevels levels;
    RefineContext context;
    PairWorker pairs; ///< working memory for distances, contacts and penetrations
    SegmentQuery segments;
    std::vector<Aabb> boxes;
    std::vector<AabbHit> hits;
    std::vector<std::pair<double, std::uint32_t>> entries; ///< entries of a segment into AABBs: fraction, slot
    std::vector<CastHit> casts;
    std::vector<SweepHit> sweeps;
    std::vector<Eigen::Isometry3d> poses; ///< poses of pairs given as columns
    std::vector<PairTask> tasks;
    std::vector<Finding> refined;
    Manifold manifold;
};

/// A worker for the time of one call.
class WorldImpl::Lease {
public:
    explicit Lease(WorldImpl& impl) : impl_(impl)
    {
        worker_ = impl.idle_workers.take();
        if (!worker_) worker_ = std::make_unique<QueryWorker>(impl, impl.settings);
        worker_->context.frame = impl.frame.number;
        worker_->context.trees = {}, worker_->context.rounds.clear();
    }
    ~Lease() { impl_.idle_workers.give_back(std::move(worker_)); }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    QueryWorker* operator->() { return worker_.get(); }
    QueryWorker& operator*() { return *worker_; }

private:
    WorldImpl& impl_;
    std::unique_ptr<QueryWorker> worker_;
};

/// Throws Error{bad_data}, which begins with the call's name, for a segment that is not finite or goes beyond 1e15 m.
void check_ends(const char* call, std::span<const Segment> segments);

/// Throws Error{usage} for a tolerance or a cutoff that is negative or NaN.
void check_distance(const DistanceOptions& options);

/// Throws Error{usage} for a negative reach, NaN, or one beyond 1e15 m.
void check_reaches(const char* what, std::span<const double> reaches);

/// Throws Error{usage} if there is not room for as many `results`, such as "hits", as there are `items`.
void same_room(const char* call, const char* items, std::size_t count, const char* results, std::size_t room);

/// Rethrows errors of check() with the number of the item, and the name of its part unless that is null: "pair 3: a: ".
template <class Check>
void naming(const char* item, std::size_t number, const char* part, Check check)
{
    try {
        check();
    } catch (const Error& error) {
        throw Error(error.kind(),
                    fmt::format("{} {}: {}{}{}", item, number, part ? part : "", part ? ": " : "", error.what()));
    }
}

/// Throws, with the number of the pair and its side, for an id or a pose that is refused.
template <class Pair>
void WorldImpl::check_pairs(std::span<const Pair> pairs)
{
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        naming("pair", i, "a", [&] { check_side(pairs[i].a); });
        naming("pair", i, "b", [&] { check_side(pairs[i].b); });
    }
}

/// Calls work(worker, i) for each item on the World's threads.
template <class Work>
void WorldImpl::each(std::size_t items, std::size_t chunk, Work work)
{
    const ExecutorScope scope(settings.executor);
    parallel_chunks(items, chunk, frame.context.threads, [&](std::size_t begin, std::size_t end, int) {
        Lease worker(*this);
        for (std::size_t i = begin; i < end; ++i) work(*worker, i);
    });
}

/// Calls work(worker, i, found), which appends to the list of item i, for each item on the World's threads. Overwrites
/// `lists`.
template <class Found, class Work>
void WorldImpl::gather(std::size_t items, std::size_t chunk, Lists<Found>& lists, Work work)
{
    auto& [found, offsets] = lists;
    found.clear(), offsets.assign(1, 0);
    const ExecutorScope scope(settings.executor);
    if (frame.context.threads == 1 || items <= chunk) { // without copies
        Lease worker(*this);
        for (std::size_t i = 0; i < items; ++i) {
            work(*worker, i, found);
            offsets.push_back(found.size());
        }
        return;
    }
    struct Part {
        std::vector<Found> found;
        std::vector<std::size_t> ends;
    };
    std::vector<Part> parts((items + chunk - 1) / chunk);
    parallel_chunks(parts.size(), 1, frame.context.threads, [&](std::size_t begin, std::size_t end, int) {
        Lease worker(*this);
        for (std::size_t k = begin; k < end; ++k)
            for (std::size_t i = k * chunk; i < std::min(items, (k + 1) * chunk); ++i) {
                work(*worker, i, parts[k].found);
                parts[k].ends.push_back(parts[k].found.size());
            }
    });
    for (const Part& part : parts) {
        for (const std::size_t end : part.ends) offsets.push_back(found.size() + end);
        found.insert(found.end(), part.found.begin(), part.found.end());
    }
}

template <class Take>
void WorldImpl::manifolds(std::span<const PairTask> tasks, const ManifoldOptions& options, ManifoldJoin& join,
                          Take take)
{
    constexpr std::size_t chunk = 16;
    if (join.at_once()) {
        const ExecutorScope scope(settings.executor);
        Lease worker(*this);
        for (std::size_t i = 0; i < tasks.size(); ++i)
            manifold(*worker, tasks[i], options, worker->manifold), take(i, StoredManifold(worker->manifold));
        return;
    }
    join.parts.resize(std::max(join.parts.size(), (tasks.size() + chunk - 1) / chunk));
    each(tasks.size(), chunk, [&](QueryWorker& worker, std::size_t i) {
        ManifoldLists& part = join.parts[i / chunk];
        if (i % chunk == 0) clear(part);
        manifold(worker, tasks[i], options, worker.manifold), append(part, StoredManifold(worker.manifold));
    });
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        if (i % chunk == 0 && i + chunk < tasks.size()) { // another thread may have written it
            const std::vector<ManifoldRegion>& later = join.parts[i / chunk + 1].regions;
            prefetch(later.data(), later.size() * sizeof(ManifoldRegion) + 1);
        }
        take(i, StoredManifold(join.parts[i / chunk], i % chunk));
    }
}

} // namespace oncollide
