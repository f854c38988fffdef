// Pairs: manifolds and near features.
#include <bit>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/pairs/manifold_tests.hpp>
#include <oncollide/pipeline/result_hash.hpp>
#include <oncollide/pipeline/world/query_worker.hpp>

namespace oncollide {

namespace {

void check_options(const ManifoldOptions& options)
{
    const auto check = [](const char* name, double value, double most) {
        if (!(value >= 0 && value <= most))
            throw Error(ErrorKind::usage, fmt::format("manifold: {} of {}; must be from 0 to {}", name, value, most));
    };
    check("margin", options.margin, 1e15), check("normal_spread", options.normal_spread, std::numbers::pi / 2);
    for (const auto& [name, value] : {std::pair("points_per_region", options.points_per_region),
                                      std::pair("regions_per_pair", options.regions_per_pair),
                                      std::pair("points_per_pair", options.points_per_pair)})
        if (value == 0) throw Error(ErrorKind::usage, fmt::format("manifold: {} of 0; must be at least 1", name));
}

} // namespace

void WorldImpl::manifold(QueryWorker& worker, const PairTask& task, const ManifoldOptions& options, Manifold& found)
{
    const auto begin = [&] { found.regions.clear(), found.points.clear(), found.complete = true; };
    const auto find = tests_for(task).manifold;
    begin();
    if (!find || reads_a_part(task))
        found.complete = false;
    else
        models.with_room([&] { begin(), find(worker.pairs, task, options, found); });
}

Manifold Pairs::manifold(PairSide a, PairSide b, const ManifoldOptions& options) const
{
    check_options(options);
    WorldImpl& p = *world_;
    const PairTask task = p.checked_task(a, b);
    p.need_trees({&task, 1});
    WorldImpl::Lease worker(p);
    Manifold found;
    p.manifold(*worker, task, options, found);
    return found;
}

void Pairs::manifold(PairSpan pairs, const ManifoldOptions& options, ManifoldLists& lists) const
{
    check_options(options);
    WorldImpl& p = *world_;
    const PairTasks tasks = p.ready_tasks("manifold", pairs);
    const ExecutorScope scope(p.settings.executor);
    ManifoldJoin join;
    join.begin(lists, p.frame.context.threads);
    p.manifolds(tasks.tasks, options, join, [&](std::size_t, const StoredManifold& found) { join.add(found); });
    join.end();
    if (options.points_in_all > 0) limit_points(lists, options.points_in_all, lists);
}

const FrameManifolds& World::manifolds(const ManifoldOptions& options)
{
    check_options(options);
    return impl().frame_manifolds.find(impl(), options);
}

void limit_points(const ManifoldLists& lists, std::size_t most, ManifoldLists& limited)
{
    std::vector<Manifold> all(lists.complete.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        const StoredManifold one(lists, i);
        all[i] = {{one.regions.begin(), one.regions.end()}, {one.points.begin(), one.points.end()}, one.complete};
        for (ManifoldRegion& region : all[i].regions) region.first -= one.regions.front().first;
    }
    limit_points(all, most);
    clear(limited);
    for (const Manifold& m : all) append(limited, StoredManifold(m));
}

namespace {

void find_near_features(WorldImpl& p, const PairTasks& tasks, double dhat, Lists<NearFeatures>& lists)
{
    for (std::size_t i = 0; i < tasks.size(); ++i)
        if (!tests_for(tasks[i]).near_features || p.reads_a_part(tasks[i]))
            throw Error(ErrorKind::usage, fmt::format("pair {}: near_features: a body is a map, round or a half-space, "
                                                      "or is read on demand; it needs triangles in memory",
                                                      i));
    p.gather(tasks.size(), 4, lists, [&](auto& worker, std::size_t i, auto& found) {
        p.models.with_room([&, begin = found.size()] {
            found.resize(begin);
            tests_for(tasks[i]).near_features(worker.pairs, tasks[i], dhat, found);
        });
    });
}

} // namespace

void check_dhat(double dhat)
{
    if (!(dhat >= 0 && dhat <= 1e15))
        throw Error(ErrorKind::usage, fmt::format("near_features: dhat of {}; must be from 0 to 1e15", dhat));
}

std::vector<NearFeatures> Pairs::near_features(PairSide a, PairSide b, double dhat) const
{
    check_dhat(dhat);
    PairTasks task{{world_->checked_task(a, b)}, {}};
    world_->need_trees(task.tasks);
    Lists<NearFeatures> lists;
    find_near_features(*world_, task, dhat, lists);
    return std::move(lists.items);
}

void Pairs::near_features(PairSpan pairs, double dhat, Lists<NearFeatures>& found) const
{
    check_dhat(dhat);
    find_near_features(*world_, world_->ready_tasks("near_features", pairs), dhat, found);
}

std::uint64_t hash_of(const ManifoldLists& lists)
{
    std::uint64_t hash = 0;
    const auto add = [&](double value) { mix(hash, std::bit_cast<std::uint64_t>(value)); };
    const auto add_vector = [&](const Eigen::Vector3d& v) { add(v.x()), add(v.y()), add(v.z()); };
    for (const std::size_t offset : lists.offsets) mix(hash, offset);
    for (const std::uint8_t complete : lists.complete) mix(hash, complete);
    for (const ManifoldRegion& r : lists.regions) {
        mix(hash, static_cast<std::uint64_t>(r.kind) << 1 | std::uint64_t{r.open});
        add_vector(r.normal), add_vector(r.centre);
        for (const double value : {r.normal_error, r.area, r.volume, r.depth_lower, r.depth_upper, r.lost}) add(value);
        mix(hash, std::uint64_t{r.first} << 32 | r.count), mix(hash, r.found);
    }
    for (const ManifoldPoint& p : lists.points) {
        add_vector(p.point_a), add_vector(p.point_b), add_vector(p.normal), add(p.depth), add(p.depth_error);
        mix(hash, p.feature_a), mix(hash, p.feature_b);
    }
    return hash;
}

} // namespace oncollide
