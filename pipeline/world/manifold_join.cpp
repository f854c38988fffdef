#include <oncollide/pipeline/world/manifold_join.hpp>

#include <algorithm>

#include <oncollide/base/simd/prefetch.hpp>
#include <oncollide/base/threads/parallel.hpp>

namespace oncollide {

void clear(ManifoldLists& lists)
{
    lists.regions.clear(), lists.points.clear(), lists.complete.clear(), lists.offsets.assign(1, 0);
}

StoredManifold::StoredManifold(const ManifoldLists& lists, std::size_t pair)
    : regions(std::span(lists.regions).subspan(lists.offsets[pair], lists.offsets[pair + 1] - lists.offsets[pair])),
      complete(lists.complete[pair])
{
    if (regions.empty()) return;
    const std::uint32_t first = regions.front().first;
    points = std::span(lists.points).subspan(first, regions.back().first + regions.back().count - first);
}

void append(ManifoldLists& lists, const StoredManifold& found)
{
    const auto before = static_cast<std::uint32_t>(lists.points.size());
    for (const ManifoldRegion& region : found.regions) {
        lists.regions.push_back(region);
        lists.regions.back().first += before - found.regions.front().first;
    }
    lists.points.insert(lists.points.end(), found.points.begin(), found.points.end());
    lists.offsets.push_back(lists.regions.size()), lists.complete.push_back(found.complete);
    // The next pair's, while it is measured.
    prefetch(lists.regions.data() + lists.regions.size(), sizeof(ManifoldRegion));
    prefetch(lists.points.data() + lists.points.size(), 4 * sizeof(ManifoldPoint));
}

void ManifoldJoin::begin(ManifoldLists& lists, int threads)
{
    lists_ = &lists, threads_ = threads;
    found_.clear();
    if (at_once()) clear(lists);
}

void ManifoldJoin::end()
{
    if (at_once()) return;
    auto& regions = lists_->regions; // no structured binding: Clang 14 lets no lambda capture one
    auto& points = lists_->points;
    auto& offsets = lists_->offsets;
    auto& complete = lists_->complete;
    offsets.resize(found_.size() + 1), complete.resize(found_.size()), first_points_.resize(found_.size());
    std::size_t region_count = 0, point_count = 0;
    for (std::size_t i = 0; i < found_.size(); ++i) {
        offsets[i] = region_count, first_points_[i] = point_count, complete[i] = found_[i].complete;
        region_count += found_[i].regions.size(), point_count += found_[i].points.size();
    }
    offsets.back() = region_count;
    regions.resize(region_count), points.resize(point_count);
    parallel_chunks(found_.size(), 256, threads_, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            const StoredManifold& from = found_[i];
            std::ranges::copy(from.points, points.data() + first_points_[i]);
            ManifoldRegion* to = regions.data() + offsets[i];
            for (const ManifoldRegion& region : from.regions) {
                *to = region;
                to++->first += static_cast<std::uint32_t>(first_points_[i]) - from.regions.front().first;
            }
        }
    });
}

std::size_t bytes_of(const ManifoldLists& lists)
{
    const auto of = [](const auto&... all) { return (... + (all.capacity() * sizeof(all[0]))); };
    return of(lists.regions, lists.points, lists.offsets, lists.complete);
}

std::size_t ManifoldJoin::bytes() const
{
    std::size_t sum = parts.capacity() * sizeof(ManifoldLists) + found_.capacity() * sizeof(StoredManifold) +
                      first_points_.capacity() * sizeof(std::size_t);
    for (const ManifoldLists& part : parts) sum += bytes_of(part);
    return sum;
}

} // namespace oncollide
