// Limits of the number of points of a pair, and of many pairs.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <oncollide/narrowphase/pairs/manifold_tests.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/candidate.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/point_hull.hpp>

namespace oncollide {

namespace {

/// The share of each taker. The takers take one piece each in turn. A taker stops at the number that the list gives for
/// it.
std::vector<std::uint32_t> shares_in_turn(std::span<const std::uint32_t> wanted, std::size_t most)
{
    std::vector<std::uint32_t> shares(wanted.size(), 0);
    for (bool more = true; more && most > 0;) {
        more = false;
        for (std::size_t i = 0; i < wanted.size() && most > 0; ++i)
            if (shares[i] < wanted[i]) ++shares[i], --most, more = true;
    }
    return shares;
}

} // namespace

void limit_points(Manifold& manifold, std::size_t most)
{
    if (manifold.points.size() <= most) return;
    manifold.complete = false;
    std::vector<std::uint32_t> wanted;
    for (const ManifoldRegion& r : manifold.regions) wanted.push_back(r.count);
    const std::vector<std::uint32_t> shares = shares_in_turn(wanted, most);
    std::vector<ManifoldPoint> kept;
    for (std::size_t i = 0; i < shares.size(); ++i) {
        ManifoldRegion& r = manifold.regions[i];
        const auto own = std::span<const ManifoldPoint>(manifold.points).subspan(r.first, r.count);
        const auto first = own.first(shares[i]);
        if (!std::isnan(r.lost)) r.lost += most_lost(first, own.subspan(shares[i]));
        r.first = static_cast<std::uint32_t>(kept.size()), r.count = shares[i];
        kept.insert(kept.end(), first.begin(), first.end());
    }
    std::erase_if(manifold.regions, [](const ManifoldRegion& r) { return r.count == 0; });
    manifold.points = std::move(kept);
}

void limit_points(std::span<Manifold> manifolds, std::size_t most)
{
    std::size_t all = 0;
    for (const Manifold& m : manifolds) all += m.points.size();
    if (all <= most) return;
    std::vector<std::uint32_t> order(manifolds.size()), wanted;
    std::iota(order.begin(), order.end(), 0u);
    const auto depth = [&](std::uint32_t i) {
        return manifolds[i].regions.empty() ? -unbounded : manifolds[i].regions.front().depth_lower;
    };
    std::ranges::stable_sort(order, std::ranges::greater{}, depth);
    for (const std::uint32_t i : order) wanted.push_back(static_cast<std::uint32_t>(manifolds[i].points.size()));
    const std::vector<std::uint32_t> shares = shares_in_turn(wanted, most);
    for (std::size_t k = 0; k < order.size(); ++k) limit_points(manifolds[order[k]], shares[k]);
}

} // namespace oncollide
