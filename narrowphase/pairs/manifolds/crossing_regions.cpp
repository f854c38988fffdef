// Regions of lumps: bodies that overlap.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include <oncollide/narrowphase/pairs/manifolds/region_draft.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

using Patches = std::vector<const Patch*>;

/// The patches of one lump.
struct LumpPatches {
    Patches a, b;
    std::vector<const CurvePoint*> curve;
};

/// A direction in which faces of both bodies are opposite each other.
struct Facing {
    Vector3d direction;
    double area_a = 0, area_b = 0;
    Patches a{}, b{};
    double matched() const { return std::min(area_a, area_b); }
    /// The distance of the middles of both sides.
    double thickness() const
    {
        const auto height = [&](const Patches& patches, double area) {
            Vector3d moment = Vector3d::Zero();
            for (const Patch* p : patches) moment += p->moment;
            return moment.dot(direction) / area;
        };
        return std::abs(height(a, area_a) - height(b, area_b));
    }
};

/// Sorts the patches by directions, the largest first, and returns the directions in which both bodies have area.
/// Patches such as the sides of a box that has sunk into the ground face nothing.
std::vector<Facing> facings(const LumpPatches& lump, double spread)
{
    struct Part {
        const Patch* patch;
        bool of_a;
    };
    std::vector<Part> parts;
    for (const Patch* p : lump.a) parts.push_back({p, true});
    for (const Patch* p : lump.b) parts.push_back({p, false});
    std::ranges::sort(parts, {}, [](const Part& p) { return std::tuple(-p.patch->area, !p.of_a, p.patch->triangle); });
    std::vector<Facing> all;
    constexpr std::size_t most = 64;
    const double least_cosine = std::cos(spread);
    for (const auto& [patch, of_a] : parts) {
        if (!(patch->area > 0)) continue;
        const Vector3d direction = of_a ? patch->normal : Vector3d(-patch->normal);
        auto at =
            std::ranges::find_if(all, [&](const Facing& f) { return f.direction.dot(direction) >= least_cosine; });
        if (at == all.end()) {
            if (all.size() == most) continue;
            all.push_back({direction}), at = all.end() - 1;
        }
        (of_a ? at->area_a : at->area_b) += patch->area;
        (of_a ? at->a : at->b).push_back(patch);
    }
    double largest = 0;
    for (const Facing& f : all) largest = std::max(largest, f.matched());
    constexpr double enough = 0.05; // of the largest
    std::erase_if(all, [&](const Facing& f) { return f.matched() <= enough * largest; });
    // Opposite sides of the overlap of two boxes are no contact.
    double thinnest = unbounded;
    for (const Facing& f : all) thinnest = std::min(thinnest, f.thickness());
    std::erase_if(all, [&](const Facing& f) {
        return f.thickness() > 4 * thinnest && f.thickness() > 0.1 * std::sqrt(f.matched());
    });
    for (Facing& f : all) std::ranges::sort(f.a), std::ranges::sort(f.b);
    return all;
}

void add_corners(RegionDraft& draft, const Patch& patch, const PlacedSurface& surface, bool of_a)
{
    for (int k = 0; k < 3; ++k) {
        if (patch.inside[k] <= 0) continue;
        const FeatureBits v = surface.vertex(patch.corners[k]);
        draft.candidates.push_back(
            {patch.points[k], of_a ? ManifoldCandidate::of_a : ManifoldCandidate::of_b, of_a ? v : 0, of_a ? 0 : v});
    }
}

Vector3d sum_of(const Patches& patches)
{
    Vector3d area = Vector3d::Zero();
    for (const Patch* p : patches) area += p->area * p->normal;
    return area;
}

/// The centre of the patches of both bodies across the normal, weighted with their area as seen along it.
Vector3d centre_of(const Patches& of_a, const Patches& of_b, const Vector3d& normal, const Vector3d& otherwise)
{
    Vector3d sum = Vector3d::Zero();
    int sides = 0;
    for (const auto& [patches, out] : {std::pair(&of_a, normal), std::pair(&of_b, Vector3d(-normal))}) {
        Vector3d moment = Vector3d::Zero();
        double area = 0, all = 0;
        for (const Patch* p : *patches) {
            const double across = p->area * p->normal.dot(out);
            area += across, all += std::abs(across), moment += p->moment * p->normal.dot(out);
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
    const OverlapPatches& overlap;
    const PlacedSurface &a, &b;
    const ManifoldOptions& options;
    Manifold& manifold;
    bool keeps_curve = false; ///< of a round solid whose support points do not reach the other body

    void add(const Lump& lump, const LumpPatches& parts, const Patches& of_a, const Patches& of_b, double share,
             bool whole, std::span<const CurvePoint* const> others = {});
    /// True if a point of the curve is on one of these patches, which are sorted by address.
    bool is_of(const CurvePoint& c, const Patches& of_a, const Patches& of_b) const
    {
        return std::ranges::binary_search(of_a, &overlap.patches[0][c.patch_a]) ||
               std::ranges::binary_search(of_b, &overlap.patches[1][c.patch_b]);
    }
    void set_normal(ManifoldRegion& region, const Lump& lump, const Patches& of_a, const Patches& of_b,
                    bool whole) const;
    void collect(RegionDraft& draft, const LumpPatches& parts, const Patches& of_a, const Patches& of_b) const;
    void exchange_round(RegionDraft& draft, const PlacedSurface& round, bool of_a, Extent& extent) const;
};

/// Sets the normal, its error and the area from the area vector.
void RegionBuilder::set_normal(ManifoldRegion& region, const Lump& lump, const Patches& of_a, const Patches& of_b,
                               bool whole) const
{
    const bool any_round = a.round() || b.round();
    const Vector3d area_a = whole ? lump.area_a : sum_of(of_a), area_b = whole ? lump.area_b : sum_of(of_b);
    // A round solid's own patches have the directions of its bounding mesh.
    const Vector3d area = a.round() ? Vector3d(-area_b) : b.round() ? area_a : Vector3d(0.5 * (area_a - area_b));
    const double gap = whole && !any_round ? (area_a + area_b).norm() : 0, error = lump.rounding + gap;
    region.area = area.norm();
    region.normal = region.area > 0 ? Vector3d(area / region.area) : Vector3d::UnitX();
    region.normal_error = region.area > 2 * error ? std::asin(error / region.area) + 0x1p-50 : std::numbers::pi;
    if (any_round) // the true patch is a part of this one, whose normals enclose the true direction
        for (const Patch* p : a.round() ? of_b : of_a) {
            const double angle = angle_between(a.round() ? Vector3d(-p->normal) : p->normal, region.normal);
            region.normal_error = std::min(std::numbers::pi, std::max(region.normal_error, 2 * angle + 0x1p-40));
        }
    constexpr double least_share = 0.5;
    const bool through = area.norm() < least_share * lump.pieces_a || area.norm() < least_share * lump.pieces_b;
    if ((whole && through) || lump.open) region.normal_error = std::numbers::pi;
}

/// Adds the candidates, the contacts and the faces of a region.
void RegionBuilder::collect(RegionDraft& draft, const LumpPatches& parts, const Patches& of_a,
                            const Patches& of_b) const
{
    for (const Patch* p : of_a) add_corners(draft, *p, a, true), draft.faces_a.emplace_back(p->triangle, p->points);
    for (const Patch* p : of_b) add_corners(draft, *p, b, false), draft.faces_b.emplace_back(p->triangle, p->points);

    const bool all = of_a.size() == parts.a.size() && of_b.size() == parts.b.size();
    for (const CurvePoint* c : parts.curve) {
        if (!all && !is_of(*c, of_a, of_b)) continue;
        draft.contacts.push_back(c->at);
        draft.candidates.push_back({c->at, ManifoldCandidate::of_both, c->a, c->b});
    }
}

/// Exchanges a round solid's candidates for points of its true surface.
void RegionBuilder::exchange_round(RegionDraft& draft, const PlacedSurface& round, bool of_a, Extent& extent) const
{
    const Vector3d out = of_a ? draft.region.normal : Vector3d(-draft.region.normal);
    const auto own = of_a ? ManifoldCandidate::of_a : ManifoldCandidate::of_b;
    const std::vector<Vector3d> points = support_points(round.model().convex(), round.rotated_back(out));
    if (keeps_curve) return;
    std::erase_if(draft.candidates, [&](const auto& c) { return c.of == own || c.of == ManifoldCandidate::of_both; });
    for (std::size_t i = 0; i < points.size(); ++i) {
        const FeatureBits feature = round.vertex(0) | i;
        draft.candidates.push_back({round.placed(points[i]), own, of_a ? feature : 0, of_a ? 0 : feature});
    }
    extent.add(draft.region.normal.dot(round.farthest(out)));
}

void RegionBuilder::add(const Lump& lump, const LumpPatches& parts, const Patches& of_a, const Patches& of_b,
                        double share, bool whole, std::span<const CurvePoint* const> others)
{
    RegionDraft draft;
    for (const CurvePoint* c : others) draft.contacts.push_back(c->at);
    draft.rounding = rounding_of(a, b);
    ManifoldRegion& region = draft.region;
    region.kind = RegionKind::crossing, region.open = lump.open || !a.solid() || !b.solid();
    set_normal(region, lump, of_a, of_b, whole);
    region.volume = lump.open ? 0 : share * std::max(lump.volume, 0.0);
    const Vector3d n = region.normal;
    collect(draft, parts, of_a, of_b);
    Extent extent_a, extent_b;
    Aabb box;
    for (const ManifoldCandidate& c : draft.candidates) {
        if (c.of != ManifoldCandidate::of_b) extent_a.add(n.dot(c.at));
        if (c.of != ManifoldCandidate::of_a) extent_b.add(n.dot(c.at));
        box.add(c.at);
    }
    if (draft.candidates.empty()) return;
    region.centre = centre_of(of_a, of_b, n, box.centre());
    if (a.round()) exchange_round(draft, a, true, extent_a);
    if (b.round()) exchange_round(draft, b, false, extent_b);
    draft.least_depth = -options.margin - 0x1p-30 * box.diagonal();
    region.depth_upper = std::max(extent_a.most - extent_b.least, 0.0) + 4 * draft.rounding + a.error() + b.error();
    const std::size_t before = manifold.regions.size();
    finish(draft, a, b, options, manifold);
    if (manifold.regions.size() == before || keeps_curve || (!a.round() && !b.round())) return;
    // The bounding mesh may reach where the solid does not.
    const std::uint32_t first = manifold.regions.back().first;
    const auto apart = [&](const ManifoldPoint& p) { return p.depth + p.depth_error < draft.least_depth; };
    if (std::ranges::all_of(std::span(manifold.points).subspan(first), apart))
        manifold.points.resize(first), manifold.regions.pop_back();
}

} // namespace

void add_crossing_regions(const OverlapPatches& overlap, const PlacedSurface& a, const PlacedSurface& b,
                          const ManifoldOptions& options, Manifold& manifold, std::vector<bool>& done)
{
    std::vector<LumpPatches> lumps(overlap.lumps.size());
    for (const Patch& p : overlap.patches[0]) lumps[p.lump].a.push_back(&p);
    for (const Patch& p : overlap.patches[1]) lumps[p.lump].b.push_back(&p);
    for (const CurvePoint& c : overlap.curve) lumps[overlap.patches[0][c.patch_a].lump].curve.push_back(&c);
    done.assign(lumps.size(), false);
    RegionBuilder builder{overlap, a, b, options, manifold};
    const double rounding = rounding_of(a, b);
    for (std::size_t i = 0; i < lumps.size(); ++i) {
        const Lump& lump = overlap.lumps[i];
        const LumpPatches& parts = lumps[i];
        if (!lump.open && lump.volume <= 16 * rounding * std::max(lump.pieces_a, lump.pieces_b)) continue; // touching
        done[i] = true;
        const std::vector<Facing> directions =
            lump.open || a.round() || b.round() ? std::vector<Facing>() : facings(parts, options.normal_spread);
        if (directions.size() < 2) {
            builder.add(lump, parts, parts.a, parts.b, 1, true);
            continue;
        }
        double matched = 0;
        for (const Facing& f : directions) matched += f.matched();
        LumpPatches rest = parts; // contacts of faces that face nothing count for the first region
        std::erase_if(rest.curve, [&](const CurvePoint* c) {
            return std::ranges::any_of(directions, [&](const Facing& f) { return builder.is_of(*c, f.a, f.b); });
        });
        for (const Facing& f : directions) {
            builder.add(lump, parts, f.a, f.b, f.matched() / matched, false, rest.curve);
            rest.curve.clear();
        }
    }
    if (!manifold.regions.empty() || (!a.round() && !b.round())) return;
    builder.keeps_curve = true;
    for (std::size_t i = 0; i < lumps.size(); ++i)
        if (done[i]) builder.add(overlap.lumps[i], lumps[i], lumps[i].a, lumps[i].b, 1, true);
}

} // namespace oncollide
