#include <oncollide/narrowphase/pairs/manifolds/facings.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <oncollide/narrowphase/pairs/manifolds/points/manifold_limits.hpp>

namespace oncollide {

using Eigen::Vector3d;

void LumpParts::set(const OverlapPatches& overlap)
{
    for (const int list : {0, 1, 2}) {
        const std::size_t count = list == 2 ? overlap.curve.size() : overlap.patches[list].size();
        const auto lump_of = [&](std::size_t i) {
            return list == 2 ? overlap.patches[0][overlap.curve[i].patch_a].lump : overlap.patches[list][i].lump;
        };
        auto& [numbers, offsets] = orders_[list];
        offsets.assign(overlap.lumps.size() + 1, 0), numbers.resize(count);
        for (std::size_t i = 0; i < count; ++i) ++offsets[lump_of(i)];
        std::exclusive_scan(offsets.begin(), offsets.end(), offsets.begin(), 0u);
        for (std::size_t i = 0; i < count; ++i) numbers[offsets[lump_of(i)]++] = static_cast<std::uint32_t>(i);
        std::shift_right(offsets.begin(), offsets.end(), 1), offsets[0] = 0;
    }
}

LumpPart LumpParts::operator[](std::size_t lump) const
{
    const auto part = [&](const Order& order) {
        const std::uint32_t first = order.offsets[lump];
        return std::span(order.numbers).subspan(first, order.offsets[lump + 1] - first);
    };
    return {part(orders_[0]), part(orders_[1]), part(orders_[2])};
}

void join_facings(LumpFacings& facings, double spread)
{
    std::vector<Facing>& all = facings.all;
    std::vector<std::uint32_t> order(all.size()), now(all.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, std::ranges::greater{},
                             [&](std::uint32_t i) { return all[i].area_a + all[i].area_b; });
    std::vector<Facing> joined;
    const double least_cosine = std::cos(spread);
    for (const std::uint32_t i : order) {
        const auto near = [&](const Facing& f) { return f.direction.dot(all[i].direction) >= least_cosine; };
        auto at = std::ranges::find_if(joined, near);
        if (at == joined.end())
            joined.push_back(all[i]), at = joined.end() - 1;
        else
            at->add(all[i]);
        now[i] = static_cast<std::uint32_t>(at - joined.begin());
    }
    for (std::uint32_t& n : facings.number)
        if (n != PatchFacings::none) n = now[n];
    all = std::move(joined);
}

void PatchFacings::clear(const OverlapPatches& overlap)
{
    for (const int side : {0, 1}) found_[side].assign(overlap.patches[side].size(), none);
}

LumpFacings PatchFacings::find(const OverlapPatches& overlap, const LumpPart& lump, double spread)
{
    using namespace manifold_limits;
    const auto& patches = overlap.patches;
    by_area_.clear();
    for (const std::uint32_t i : lump.a) by_area_.emplace_back(-patches[0][i].area, 2 * i);
    for (const std::uint32_t i : lump.b) by_area_.emplace_back(-patches[1][i].area, 2 * i + 1);
    std::ranges::sort(by_area_);
    std::vector<Facing> all;
    const double least_cosine = std::cos(spread);
    for (const auto& [area, i] : by_area_) {
        if (!(area < 0)) continue;
        const bool of_a = i % 2 == 0;
        const Patch& patch = patches[i % 2][i / 2];
        const Vector3d direction = of_a ? patch.normal : Vector3d(-patch.normal);
        auto at =
            std::ranges::find_if(all, [&](const Facing& f) { return f.direction.dot(direction) >= least_cosine; });
        if (at == all.end()) {
            if (all.size() == most_facings) continue;
            all.push_back({direction}), at = all.end() - 1;
        }
        (of_a ? at->area_a : at->area_b) += patch.area;
        (of_a ? at->moment_a : at->moment_b) += patch.moment;
        found_[i % 2][i / 2] = static_cast<std::uint32_t>(at - all.begin());
    }
    double largest = 0, thinnest = std::numeric_limits<double>::infinity();
    for (const Facing& f : all) largest = std::max(largest, f.matched());
    const auto matches = [&](const Facing& f) { return f.matched() > matched_share * largest; };
    for (const Facing& f : all)
        if (matches(f)) thinnest = std::min(thinnest, f.thickness());
    // Opposite sides of the overlap of two boxes are not a contact.
    const auto thin = [&](const Facing& f) {
        return f.thickness() <= thick_factor * thinnest || f.thickness() <= thin_share * std::sqrt(f.matched());
    };
    LumpFacings found;
    for (const Facing& f : all) {
        const bool keep = matches(f) && thin(f);
        found.number.push_back(keep ? static_cast<std::uint32_t>(found.all.size()) : none);
        if (keep) found.all.push_back(f);
    }
    return found;
}

} // namespace oncollide
