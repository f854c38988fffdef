#include <oncollide/pipeline/manifold_tracker.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/world.hpp>

namespace oncollide {

namespace {

/// Throws unless the regions of the pairs, and the points of the regions, are in the lists.
void check_lists(const ManifoldLists& lists)
{
    const auto refuse = [](const std::string& what) { throw Error(ErrorKind::usage, "ManifoldTracker: " + what); };
    if (lists.offsets.front() != 0 || lists.offsets.back() != lists.regions.size() ||
        !std::ranges::is_sorted(lists.offsets))
        refuse(fmt::format("the offsets must ascend from 0 to {}, the number of regions", lists.regions.size()));
    for (std::size_t i = 0; i < lists.regions.size(); ++i) {
        const std::size_t first = lists.regions[i].first, count = lists.regions[i].count;
        if (first + count > lists.points.size())
            refuse(fmt::format("region {} has the points {} to {}; there are {}", i, first, first + count,
                               lists.points.size()));
    }
}

} // namespace

ManifoldTracker::ManifoldTracker(double match_distance) : match_distance_(match_distance)
{
    if (!(match_distance >= 0))
        throw Error(ErrorKind::usage,
                    fmt::format("ManifoldTracker: a match_distance of {}; must be 0 or more", match_distance));
}

/// Matches one to one: first equal features, then the nearest, each by distance and then by index.
void ManifoldTracker::match(const PointsOfPair& before, const PointsOfPair& now)
{
    constexpr double least_cosine = 0.99619469809174555; // 5 degrees
    std::vector<std::tuple<bool, double, std::uint32_t, std::uint32_t>> matches;
    for (std::uint32_t i = now.first; i < now.end; ++i)
        for (std::uint32_t k = before.first; k < before.end; ++k) {
            const Point &x = now_.points[i], &y = last_.points[k];
            if (x.normal.dot(y.normal) < least_cosine) continue;
            const double distance = std::min((x.in_a - y.in_a).norm(), (x.in_b - y.in_b).norm());
            const bool others = x.feature_a != y.feature_a || x.feature_b != y.feature_b;
            if (others && distance > match_distance_) continue;
            matches.emplace_back(others, distance, i, k);
        }
    std::ranges::sort(matches);
    for (const auto& [others, distance, i, k] : matches) {
        if (update_.previous[i] != none || update_.ids[i] != 0 || last_.points[k].id == 0) continue;
        update_.previous[i] = k, update_.ids[i] = last_.points[k].id;
        last_.points[k].id = 0; // taken
    }
}

const ManifoldTracker::Update& ManifoldTracker::update(const World& world, std::span<const PairOfBodies> pairs,
                                                       const ManifoldLists& manifolds)
{
    if (manifolds.offsets.size() != pairs.size() + 1)
        throw Error(ErrorKind::usage,
                    fmt::format("ManifoldTracker: {} pairs, but manifolds of {}; must be of one length", pairs.size(),
                                std::max<std::size_t>(manifolds.offsets.size(), 1) - 1));
    check_lists(manifolds);
    now_.points.resize(manifolds.points.size()), now_.pairs.clear();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const auto regions =
            std::span(manifolds.regions).subspan(manifolds.offsets[i], manifolds.offsets[i + 1] - manifolds.offsets[i]);
        if (regions.empty()) continue;
        const Eigen::Isometry3d a = world.bodies().pose(pairs[i].a).inverse(Eigen::Isometry),
                                b = world.bodies().pose(pairs[i].b).inverse(Eigen::Isometry);
        for (const ManifoldRegion& region : regions)
            for (std::uint32_t k = region.first; k < region.first + region.count; ++k) {
                const ManifoldPoint& p = manifolds.points[k];
                now_.points[k] = {
                    p.feature_a, p.feature_b, a * p.point_a, b * p.point_b, a.linear() * region.normal, 0};
            }
        now_.pairs.push_back({pairs[i], regions.front().first, regions.back().first + regions.back().count});
    }
    std::ranges::sort(now_.pairs, {}, &PointsOfPair::pair);
    update_.previous.assign(now_.points.size(), none), update_.ids.assign(now_.points.size(), 0);
    auto before = last_.pairs.begin();
    for (const PointsOfPair& now : now_.pairs) {
        while (before != last_.pairs.end() && before->pair < now.pair) ++before;
        if (before != last_.pairs.end() && before->pair == now.pair) match(*before, now);
    }
    update_.ended.clear();
    for (std::uint32_t k = 0; k < last_.points.size(); ++k)
        if (last_.points[k].id != 0) update_.ended.push_back(k);
    for (std::size_t i = 0; i < now_.points.size(); ++i) {
        if (update_.ids[i] == 0) update_.ids[i] = ++next_id_;
        now_.points[i].id = update_.ids[i];
    }
    std::swap(last_, now_);
    return update_;
}

} // namespace oncollide
