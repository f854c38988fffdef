// Regions of lumps: bodies that overlap.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <oncollide/narrowphase/pairs/manifolds/region_draft.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

constexpr std::uint32_t none = OverlapPatches::none;
using Numbers = std::span<const std::uint32_t>;

/// Patches of both bodies, and points of the curve, by their numbers: of a lump, or of one direction of it.
struct Part {
    Numbers a, b, curve;
};

/// A direction in which faces of both bodies are opposite each other.
struct Facing {
    Vector3d direction;
    double area_a = 0, area_b = 0;
    Vector3d moment_a = Vector3d::Zero(), moment_b = Vector3d::Zero();

    double matched() const { return std::min(area_a, area_b); }
    /// The distance of the middles of both sides.
    double thickness() const { return std::abs((moment_a / area_a - moment_b / area_b).dot(direction)); }
    void add(const Facing& other)
    {
        area_a += other.area_a, area_b += other.area_b, moment_a += other.moment_a, moment_b += other.moment_b;
    }
};

/// The directions of a lump, and for each number that its patches have the direction that took it in.
struct LumpFacings {
    std::vector<Facing> all;
    std::vector<std::uint32_t> number; ///< none: faces nothing
};

/// Joins directions within `spread` of a larger one.
void join_facings(std::vector<Facing>& all, std::vector<std::uint32_t>& number, double spread)
{
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
    for (std::uint32_t& n : number)
        if (n != none) n = now[n];
    all = std::move(joined);
}

/// Sorts the patches by directions, the largest first, and finds the directions in which both bodies have area. Patches
/// such as the sides of a box that has sunk into the ground face nothing.
LumpFacings facings_of(ManifoldMemory& memory, const Part& lump, double spread)
{
    const auto& patches = memory.overlap.patches;
    auto& by_area = memory.by_area;
    by_area.clear();
    for (const std::uint32_t i : lump.a) by_area.emplace_back(-patches[0][i].area, 2 * i);
    for (const std::uint32_t i : lump.b) by_area.emplace_back(-patches[1][i].area, 2 * i + 1);
    std::ranges::sort(by_area);
    LumpFacings found;
    std::vector<Facing>& all = found.all;
    constexpr std::size_t most = 64;
    const double least_cosine = std::cos(spread);
    for (const auto& [area, i] : by_area) {
        if (!(area < 0)) continue;
        const bool of_a = i % 2 == 0;
        const Patch& patch = patches[i % 2][i / 2];
        const Vector3d direction = of_a ? patch.normal : Vector3d(-patch.normal);
        auto at =
            std::ranges::find_if(all, [&](const Facing& f) { return f.direction.dot(direction) >= least_cosine; });
        if (at == all.end()) {
            if (all.size() == most) continue;
            all.push_back({direction}), at = all.end() - 1;
        }
        (of_a ? at->area_a : at->area_b) += patch.area;
        (of_a ? at->moment_a : at->moment_b) += patch.moment;
        memory.facing[i % 2][i / 2] = static_cast<std::uint32_t>(at - all.begin());
    }
    double largest = 0, thinnest = unbounded;
    for (const Facing& f : all) largest = std::max(largest, f.matched());
    constexpr double enough = 0.05; // of the largest
    const auto matches = [&](const Facing& f) { return f.matched() > enough * largest; };
    for (const Facing& f : all)
        if (matches(f)) thinnest = std::min(thinnest, f.thickness());
    // Opposite sides of the overlap of two boxes are no contact.
    const auto thin = [&](const Facing& f) {
        return f.thickness() <= 4 * thinnest || f.thickness() <= 0.1 * std::sqrt(f.matched());
    };
    std::vector<Facing> kept;
    for (const Facing& f : all) {
        const bool keep = matches(f) && thin(f);
        found.number.push_back(keep ? static_cast<std::uint32_t>(kept.size()) : none);
        if (keep) kept.push_back(f);
    }
    all = std::move(kept);
    return found;
}

/// The centre of the patches of both bodies across the normal, weighted with their area as seen along it.
Vector3d centre_of(const OverlapPatches& overlap, const Part& part, const Vector3d& normal, const Vector3d& otherwise)
{
    Vector3d sum = Vector3d::Zero();
    int sides = 0;
    for (const int side : {0, 1}) {
        const Vector3d out = side == 0 ? normal : Vector3d(-normal);
        Vector3d moment = Vector3d::Zero();
        double area = 0, all = 0;
        for (const std::uint32_t i : side == 0 ? part.a : part.b) {
            const Patch& p = overlap.patches[side][i];
            const double slope = p.normal.dot(out), across = p.area * slope;
            area += across, all += std::abs(across), moment += p.moment * slope;
        }
        if (area > 0x1p-20 * all && (moment / area).allFinite()) sum += moment / area, ++sides;
    }
    return sides ? Vector3d(sum / sides) : otherwise;
}

/// The largest and the least projection of points onto the normal.
struct Extent {
    double least = unbounded, most = -unbounded;
    void add(double h) { least = std::min(least, h), most = std::max(most, h); }
};

struct RegionBuilder {
    ManifoldMemory& memory;
    const PlacedSurface &a, &b;
    const ManifoldOptions& options;
    Manifold& manifold;
    bool keeps_curve = false; ///< of a round solid whose support points do not reach the other body

    /// @param whole   the part is the whole lump
    /// @param others  points of the curve that are no candidates
    void add(const Lump& lump, const Part& part, double share, bool whole, Numbers others = {});
    Vector3d sum_of(int side, Numbers numbers) const
    {
        Vector3d area = Vector3d::Zero();
        for (const std::uint32_t i : numbers) {
            const Patch& p = memory.overlap.patches[side][i];
            area += p.area * p.normal;
        }
        return area;
    }
    void set_normal(ManifoldRegion& region, const Lump& lump, const Part& part, bool whole) const;
    void collect(const Part& part);
    void exchange_round(const PlacedSurface& round, bool of_a, Extent& extent) const;
};

/// Sets the normal, its error and the area from the area vector.
void RegionBuilder::set_normal(ManifoldRegion& region, const Lump& lump, const Part& part, bool whole) const
{
    const bool any_round = a.round() || b.round();
    const Vector3d area_a = whole ? lump.area_a : sum_of(0, part.a), area_b = whole ? lump.area_b : sum_of(1, part.b);
    // A round solid's own patches have the directions of its bounding mesh.
    const Vector3d area = a.round() ? Vector3d(-area_b) : b.round() ? area_a : Vector3d(0.5 * (area_a - area_b));
    const double gap = whole && !any_round ? (area_a + area_b).norm() : 0, error = lump.rounding + gap;
    region.area = area.norm();
    region.normal = region.area > 0 ? Vector3d(area / region.area) : Vector3d::UnitX();
    region.normal_error = region.area > 2 * error ? std::asin(error / region.area) + 0x1p-50 : std::numbers::pi;
    if (any_round) // the true patch is a part of this one, whose normals enclose the true direction
        for (const std::uint32_t i : a.round() ? part.b : part.a) {
            const Vector3d& n = memory.overlap.patches[a.round() ? 1 : 0][i].normal;
            const double angle = angle_between(a.round() ? Vector3d(-n) : n, region.normal);
            region.normal_error = std::min(std::numbers::pi, std::max(region.normal_error, 2 * angle + 0x1p-40));
        }
    constexpr double least_share = 0.5;
    const bool through = area.norm() < least_share * lump.pieces_a || area.norm() < least_share * lump.pieces_b;
    if ((whole && through) || lump.open) region.normal_error = std::numbers::pi;
}

/// Adds the candidates, the contacts and the faces of a region.
void RegionBuilder::collect(const Part& part)
{
    RegionDraft& draft = memory.draft;
    for (const int side : {0, 1}) {
        const PlacedSurface& surface = side == 0 ? a : b;
        auto& faces = side == 0 ? draft.faces_a : draft.faces_b;
        const std::size_t first = draft.candidates.size();
        memory.vertices.clear();
        for (const std::uint32_t i : side == 0 ? part.a : part.b) {
            const Patch& p = memory.overlap.patches[side][i];
            const Vector3d normal = side == 0 ? p.normal : Vector3d(-p.normal);
            faces.emplace_back(p.triangle, p.points);
            for (int k = 0; k < 3; ++k) {
                if (p.inside[k] <= 0) continue;
                bool is_new;
                const std::uint32_t number = memory.vertices.add(p.corners[k], is_new);
                if (!is_new) { // the face that agrees best with the region
                    ManifoldCandidate& known = draft.candidates[first + number];
                    if (normal.dot(draft.region.normal) > known.normal.dot(draft.region.normal)) known.normal = normal;
                    continue;
                }
                const FeatureBits v = surface.vertex(p.corners[k]);
                if (side == 0)
                    draft.candidates.push_back({p.points[k], ManifoldCandidate::of_a, v, 0, 0, 0, true, normal});
                else
                    draft.candidates.push_back({p.points[k], ManifoldCandidate::of_b, 0, v, 0, 0, true, normal});
            }
        }
    }
    for (const std::uint32_t i : part.curve) {
        const CurvePoint& c = memory.overlap.curve[i];
        const std::size_t before = draft.candidates.size();
        const Vector3d normal =
            normal_across(memory.overlap.patches[0][c.patch_a].normal, -memory.overlap.patches[1][c.patch_b].normal);
        draft.add_shared({c.at, ManifoldCandidate::of_both, c.a, c.b, 0, 0, true, normal});
        if (draft.candidates.size() > before) draft.contacts.push_back(c.at);
    }
}

/// Exchanges a round solid's candidates for points of its true surface.
void RegionBuilder::exchange_round(const PlacedSurface& round, bool of_a, Extent& extent) const
{
    if (keeps_curve) return;
    RegionDraft& draft = memory.draft;
    const Vector3d out = of_a ? draft.region.normal : Vector3d(-draft.region.normal);
    const auto own = of_a ? ManifoldCandidate::of_a : ManifoldCandidate::of_b;
    const std::vector<Vector3d> points = support_points(round.model().convex(), round.rotated_back(out));
    std::erase_if(draft.candidates, [&](const auto& c) { return c.of == own || c.of == ManifoldCandidate::of_both; });
    for (std::size_t i = 0; i < points.size(); ++i) {
        const FeatureBits feature = round.vertex(0) | i;
        draft.candidates.push_back({round.placed(points[i]), own, of_a ? feature : 0, of_a ? 0 : feature});
    }
    extent.add(draft.region.normal.dot(round.farthest(out)));
}

void RegionBuilder::add(const Lump& lump, const Part& part, double share, bool whole, Numbers others)
{
    RegionDraft& draft = memory.draft;
    draft.clear();
    for (const std::uint32_t i : others) draft.contacts.push_back(memory.overlap.curve[i].at);
    draft.rounding = rounding_of(a, b);
    ManifoldRegion& region = draft.region;
    region.kind = RegionKind::crossing, region.open = lump.open || !a.solid() || !b.solid();
    set_normal(region, lump, part, whole);
    region.volume = lump.open ? 0 : share * std::max(lump.volume, 0.0);
    const Vector3d n = region.normal;
    collect(part);
    Extent extent_a, extent_b;
    Aabb box;
    for (const ManifoldCandidate& c : draft.candidates) {
        if (c.of != ManifoldCandidate::of_b) extent_a.add(n.dot(c.at));
        if (c.of != ManifoldCandidate::of_a) extent_b.add(n.dot(c.at));
        box.add(c.at);
    }
    if (draft.candidates.empty()) return;
    region.centre = centre_of(memory.overlap, part, n, box.centre());
    if (a.round()) exchange_round(a, true, extent_a);
    if (b.round()) exchange_round(b, false, extent_b);
    draft.least_depth = -options.margin - 0x1p-30 * box.diagonal();
    region.depth_upper = std::max(extent_a.most - extent_b.least, 0.0) + 4 * draft.rounding + a.error() + b.error();
    const std::size_t before = manifold.regions.size();
    finish(memory, a, b, options, manifold);
    if (manifold.regions.size() == before || keeps_curve || (!a.round() && !b.round())) return;
    // The bounding mesh may reach where the solid does not.
    const std::uint32_t first = manifold.regions.back().first;
    const auto apart = [&](const ManifoldPoint& p) { return p.depth + p.depth_error < draft.least_depth; };
    if (std::ranges::all_of(std::span(manifold.points).subspan(first), apart))
        manifold.points.resize(first), manifold.regions.pop_back();
}

/// Sorts numbers of patches and of points of the curve by their lumps.
void sort_by_lump(ManifoldMemory& memory)
{
    const OverlapPatches& overlap = memory.overlap;
    const std::size_t lumps = overlap.lumps.size();
    for (const int list : {0, 1, 2}) {
        const std::size_t count = list == 2 ? overlap.curve.size() : overlap.patches[list].size();
        const auto lump_of = [&](std::size_t i) {
            return list == 2 ? overlap.patches[0][overlap.curve[i].patch_a].lump : overlap.patches[list][i].lump;
        };
        auto &offsets = memory.offsets[list], &order = memory.order[list];
        offsets.assign(lumps + 1, 0), order.resize(count);
        for (std::size_t i = 0; i < count; ++i) ++offsets[lump_of(i)];
        std::exclusive_scan(offsets.begin(), offsets.end(), offsets.begin(), 0u);
        for (std::size_t i = 0; i < count; ++i) order[offsets[lump_of(i)]++] = static_cast<std::uint32_t>(i);
        std::shift_right(offsets.begin(), offsets.end(), 1), offsets[0] = 0;
    }
}

Part part_of(const ManifoldMemory& memory, std::size_t lump)
{
    const auto numbers = [&](int list) {
        const auto& offsets = memory.offsets[list];
        return Numbers(memory.order[list]).subspan(offsets[lump], offsets[lump + 1] - offsets[lump]);
    };
    return {numbers(0), numbers(1), numbers(2)};
}

/// Adds a region for each direction of a lump.
void add_directions(RegionBuilder& builder, const Lump& lump, const Part& part, const LumpFacings& facings)
{
    ManifoldMemory& memory = builder.memory;
    const OverlapPatches& overlap = memory.overlap;
    const auto facing_of = [&](int side, std::uint32_t patch) {
        const std::uint32_t f = memory.facing[side][patch];
        return f == none ? none : facings.number[f];
    };
    double matched = 0;
    for (const Facing& f : facings.all) matched += f.matched();
    std::vector<std::uint32_t> rest; // contacts of faces that face nothing count for the first region
    for (const std::uint32_t i : part.curve) {
        const CurvePoint& c = overlap.curve[i];
        if (facing_of(0, c.patch_a) == none && facing_of(1, c.patch_b) == none) rest.push_back(i);
    }
    auto& of = memory.of_facing;
    of.resize(std::max(of.size(), facings.all.size()));
    for (auto& lists : of)
        for (auto& list : lists) list.clear();
    for (const std::uint32_t i : part.a)
        if (const std::uint32_t f = facing_of(0, i); f != none) of[f][0].push_back(i);
    for (const std::uint32_t i : part.b)
        if (const std::uint32_t f = facing_of(1, i); f != none) of[f][1].push_back(i);
    for (const std::uint32_t i : part.curve) {
        const CurvePoint& c = overlap.curve[i];
        const std::uint32_t f = facing_of(0, c.patch_a), g = facing_of(1, c.patch_b);
        if (f != none) of[f][2].push_back(i);
        if (g != none && g != f) of[g][2].push_back(i);
    }
    for (std::uint32_t number = 0; number < facings.all.size(); ++number) {
        builder.add(lump, {of[number][0], of[number][1], of[number][2]}, facings.all[number].matched() / matched, false,
                    rest);
        rest.clear();
    }
}

} // namespace

void add_crossing_regions(ManifoldMemory& memory, const PlacedSurface& a, const PlacedSurface& b,
                          const ManifoldOptions& options, Manifold& manifold)
{
    const OverlapPatches& overlap = memory.overlap;
    const std::size_t count = overlap.lumps.size();
    sort_by_lump(memory);
    for (const int side : {0, 1}) memory.facing[side].assign(overlap.patches[side].size(), none);
    memory.done.assign(count, false);
    RegionBuilder builder{memory, a, b, options, manifold};
    const bool any_round = a.round() || b.round();
    const double rounding = rounding_of(a, b);
    std::vector<LumpFacings> facings(count);
    std::size_t regions = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const Lump& lump = overlap.lumps[i];
        if (!lump.open && lump.volume <= 16 * rounding * std::max(lump.pieces_a, lump.pieces_b)) continue; // touching
        memory.done[i] = true;
        if (!lump.open && !any_round) facings[i] = facings_of(memory, part_of(memory, i), options.normal_spread);
        regions += std::max<std::size_t>(facings[i].all.size(), 1);
    }
    // More directions than regions: faces of one region differ more.
    constexpr double most_spread = std::numbers::pi / 3;
    for (double spread = std::max(options.normal_spread, 0.05);
         regions > most_regions(options) && spread < most_spread;) {
        spread = std::min(1.5 * spread, most_spread), regions = 0;
        for (std::size_t i = 0; i < count; ++i) {
            if (facings[i].all.size() > 1) join_facings(facings[i].all, facings[i].number, spread);
            regions += memory.done[i] ? std::max<std::size_t>(facings[i].all.size(), 1) : 0;
        }
    }
    for (std::size_t i = 0; i < count; ++i) {
        if (!memory.done[i]) continue;
        const Part part = part_of(memory, i);
        if (facings[i].all.size() < 2)
            builder.add(overlap.lumps[i], part, 1, true);
        else
            add_directions(builder, overlap.lumps[i], part, facings[i]);
    }
    if (!manifold.regions.empty() || !any_round) return;
    builder.keeps_curve = true;
    for (std::size_t i = 0; i < count; ++i)
        if (memory.done[i]) builder.add(overlap.lumps[i], part_of(memory, i), 1, true);
}

} // namespace oncollide
