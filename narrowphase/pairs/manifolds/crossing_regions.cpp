#include <oncollide/narrowphase/pairs/manifolds/crossing_regions.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace oncollide {

using Eigen::Vector3d;

namespace {

/// The centre of the patches of both bodies across the normal, weighted with their area as seen along it.
Vector3d centre_of(const OverlapPatches& overlap, const LumpPart& part, const Vector3d& normal,
                   const Vector3d& otherwise)
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

} // namespace

/// Adds regions to one job.
struct CrossingRegions::Builder {
    CrossingRegions& memory;
    const ManifoldJob& job;
    const OverlapPatches& overlap;
    RegionMaker& maker;

    /// @param whole   the part is the whole lump
    /// @param others  points of the curve that are not candidates
    void add(const Lump& lump, const LumpPart& part, double share, bool whole,
             std::span<const std::uint32_t> others = {});
    void add_directions(const Lump& lump, const LumpPart& part, const LumpFacings& facings);

private:
    Vector3d sum_of(int side, std::span<const std::uint32_t> numbers) const;
    void set_normal(ManifoldRegion& region, const Lump& lump, const LumpPart& part, bool whole) const;
    void collect(const LumpPart& part);
};

/// The area vector of patches.
Vector3d CrossingRegions::Builder::sum_of(int side, std::span<const std::uint32_t> numbers) const
{
    Vector3d area = Vector3d::Zero();
    for (const std::uint32_t i : numbers) {
        const Patch& p = overlap.patches[side][i];
        area += p.area * p.normal;
    }
    return area;
}

/// Sets the normal, its error and the area from the area vector.
void CrossingRegions::Builder::set_normal(ManifoldRegion& region, const Lump& lump, const LumpPart& part,
                                          bool whole) const
{
    const Vector3d area_a = whole ? lump.area_a : sum_of(0, part.a), area_b = whole ? lump.area_b : sum_of(1, part.b);
    const Vector3d area = 0.5 * (area_a - area_b);
    const double gap = whole ? (area_a + area_b).norm() : 0, error = lump.rounding + gap;
    region.area = area.norm();
    region.normal = region.area > 0 ? Vector3d(area / region.area) : Vector3d::UnitX();
    region.normal_error = region.area > 2 * error ? std::asin(error / region.area) + 0x1p-50 : std::numbers::pi;
    constexpr double least_share = manifold_limits::least_flat_share;
    const bool through = area.norm() < least_share * lump.pieces_a || area.norm() < least_share * lump.pieces_b;
    if ((whole && through) || lump.open) region.normal_error = std::numbers::pi;
}

/// Adds the candidates, the contacts and the faces of a region.
void CrossingRegions::Builder::collect(const LumpPart& part)
{
    RegionDraft& draft = maker.draft;
    KeyNumbers& vertices = memory.vertices_;
    for (const int side : {0, 1}) {
        const PlacedSurface& surface = job.surface(side);
        const std::size_t first = draft.candidates.size();
        vertices.clear();
        for (const std::uint32_t i : side == 0 ? part.a : part.b) {
            const Patch& p = overlap.patches[side][i];
            const Vector3d normal = side == 0 ? p.normal : Vector3d(-p.normal);
            draft.faces[side].push_back({p.triangle, p.points});
            for (int k = 0; k < 3; ++k) {
                if (p.inside[k] <= 0) continue;
                bool is_new;
                const std::uint32_t number = vertices.add(p.corners[k], is_new);
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
        const CurvePoint& c = overlap.curve[i];
        const std::size_t before = draft.candidates.size();
        const Vector3d normal =
            normal_across(overlap.patches[0][c.patch_a].normal, -overlap.patches[1][c.patch_b].normal);
        draft.add_shared({c.at, ManifoldCandidate::of_both, c.a, c.b, 0, 0, true, normal});
        if (draft.candidates.size() > before) draft.contacts.push_back(c.at);
    }
}

void CrossingRegions::Builder::add(const Lump& lump, const LumpPart& part, double share, bool whole,
                                   std::span<const std::uint32_t> others)
{
    RegionDraft& draft = maker.draft;
    draft.begin(RegionKind::crossing, lump.open || !job.solid(), job.rounding);
    for (const std::uint32_t i : others) draft.contacts.push_back(overlap.curve[i].at);
    ManifoldRegion& region = draft.region;
    set_normal(region, lump, part, whole);
    region.volume = lump.open ? 0 : share * std::max(lump.volume, 0.0);
    collect(part);
    Extent extent_a, extent_b;
    Aabb box;
    for (const ManifoldCandidate& c : draft.candidates) {
        if (c.of != ManifoldCandidate::of_b) extent_a.add(region.normal.dot(c.at));
        if (c.of != ManifoldCandidate::of_a) extent_b.add(region.normal.dot(c.at));
        box.add(c.at);
    }
    if (draft.candidates.empty()) return;
    region.centre = centre_of(overlap, part, region.normal, box.centre());
    draft.least_depth = -job.options.margin - 0x1p-30 * box.diagonal();
    region.depth_upper =
        std::max(extent_a.most - extent_b.least, 0.0) + 4 * draft.rounding + job.a.error() + job.b.error();
    maker.finish(job);
}

/// Adds a region for each direction of a lump.
void CrossingRegions::Builder::add_directions(const Lump& lump, const LumpPart& part, const LumpFacings& facings)
{
    constexpr std::uint32_t none = PatchFacings::none;
    const auto facing_of = [&](int side, std::uint32_t patch) { return memory.facings_.of(side, patch, facings); };
    double matched = 0;
    for (const Facing& f : facings.all) matched += f.matched();
    std::vector<std::uint32_t> rest; // contacts of faces that face nothing count for the first region
    for (const std::uint32_t i : part.curve) {
        const CurvePoint& c = overlap.curve[i];
        if (facing_of(0, c.patch_a) == none && facing_of(1, c.patch_b) == none) rest.push_back(i);
    }
    auto& of = memory.of_facing_;
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
        const auto& [of_a, of_b, curve] = of[number];
        add(lump, {of_a, of_b, curve}, facings.all[number].matched() / matched, false, rest);
        rest.clear();
    }
}

void CrossingRegions::add(const ManifoldJob& job, const OverlapPatches& overlap, RegionMaker& maker)
{
    std::vector<std::uint32_t> lumps; // lumps that have regions
    for (std::uint32_t i = 0; i < overlap.lumps.size(); ++i)
        if (overlap.lumps[i].has_volume(job.rounding)) lumps.push_back(i);
    if (lumps.empty()) return;
    parts_.set(overlap), facings_.clear(overlap);
    std::vector<LumpFacings> facings(lumps.size());
    const auto count_regions = [&] {
        std::size_t regions = 0;
        for (const LumpFacings& f : facings) regions += std::max<std::size_t>(f.all.size(), 1);
        return regions;
    };
    for (std::size_t i = 0; i < lumps.size(); ++i)
        if (!overlap.lumps[lumps[i]].open)
            facings[i] = facings_.find(overlap, parts_[lumps[i]], job.options.normal_spread);
    using manifold_limits::most_spread;
    // If there are more directions than regions, the faces of one region may differ more.
    for (double spread = std::max(job.options.normal_spread, manifold_limits::least_widened);
         count_regions() > job.most_regions() && spread < most_spread;) {
        spread = std::min(manifold_limits::widening * spread, most_spread);
        for (LumpFacings& f : facings)
            if (f.all.size() > 1) join_facings(f, spread);
    }
    Builder builder{*this, job, overlap, maker};
    for (std::size_t i = 0; i < lumps.size(); ++i) {
        const Lump& lump = overlap.lumps[lumps[i]];
        if (facings[i].all.size() < 2)
            builder.add(lump, parts_[lumps[i]], 1, true);
        else
            builder.add_directions(lump, parts_[lumps[i]], facings[i]);
    }
}

} // namespace oncollide
