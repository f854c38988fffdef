// Chooses the points of a region.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include <oncollide/narrowphase/pairs/manifolds/region_draft.hpp>
#include <oncollide/narrowphase/rays/segment_entry.hpp>

namespace oncollide {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double same_share = 1e-6; ///< share of a region's size that no point needs to be apart

auto key_of(const ManifoldCandidate& c)
{
    return std::tuple(c.a, c.b, c.of, c.at.x(), c.at.y(), c.at.z());
}

double turn(const Vector2d& u, const Vector2d& v)
{
    return u.x() * v.y() - u.y() * v.x();
}

} // namespace

void FacesAhead::set(const std::vector<std::pair<std::uint32_t, TrianglePoints>>& all, const Vector3d& direction)
{
    faces.clear();
    if (!all.empty()) origin = all.front().second[0];
    for (const auto& [number, t] : all) {
        const Vector3d from = t[0] - origin, u = t[1] - t[0], v = t[2] - t[0], n = u.cross(v);
        const double length = n.norm(), slope = direction.dot(n);
        if (!(slope > 1e-6 * length)) continue;
        Face face{-n / slope, v.cross(direction) / slope, direction.cross(u) / slope, 0, 0, 0, length / slope, number};
        face.depth_0 = -face.depth.dot(from);
        face.second_0 = -face.second.dot(from), face.third_0 = -face.third.dot(from);
        faces.push_back(face);
    }
}

const FacesAhead::Face* FacesAhead::nearest(const Vector3d& p, double& depth) const
{
    const Vector3d at = p - origin;
    const Face* nearest = nullptr;
    depth = unbounded;
    for (const Face& face : faces) {
        const double s = face.second.dot(at) + face.second_0, r = face.third.dot(at) + face.third_0;
        if (s < -1e-9 || r < -1e-9 || s + r > 1 + 1e-9) continue;
        const double d = face.depth.dot(at) + face.depth_0;
        if (std::abs(d) < std::abs(depth)) depth = d, nearest = &face;
    }
    return nearest;
}

void RegionDraft::clear()
{
    ManifoldRegion blank{};
    blank.normal.setZero(), blank.centre.setZero();
    region = blank, candidates.clear(), contacts.clear(), faces_a.clear(), faces_b.clear();
    rounding = 0, least_depth = 0;
    shared_.clear(), candidate_of_.clear();
}

void RegionDraft::add_shared(const ManifoldCandidate& candidate)
{
    bool is_new;
    const std::uint32_t number = shared_.add(candidate.a ^ std::rotl(candidate.b, 23), is_new);
    if (is_new) {
        candidate_of_.push_back(static_cast<std::uint32_t>(candidates.size()));
    } else if (ManifoldCandidate& known = candidates[candidate_of_[number]];
               known.a == candidate.a && known.b == candidate.b) {
        if (known.normal.isZero(0)) known.normal = candidate.normal; // another face at the edge is opposite
        return;
    }
    candidates.push_back(candidate);
}

/// Keeps the candidate of the largest value above `least`; of nearly equal ones the deepest, then the first by its key,
/// so that ties do not depend on the order of the candidates.
void PointChoice::take(auto value, double least, double tie)
{
    const std::vector<ManifoldCandidate>& all = *all_;
    double most = -unbounded, deepest = -unbounded;
    for (std::size_t i = 0; i < all.size(); ++i) most = std::max(most, values_[i] = value(i));
    if (!(most > least) && !kept_.empty()) return;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (values_[i] >= most - tie) deepest = std::max(deepest, all[i].depth);
    auto best = static_cast<std::uint32_t>(all.size());
    for (std::uint32_t i = 0; i < all.size(); ++i)
        if (values_[i] >= most - tie && all[i].depth >= deepest - 1e-9 * size_ &&
            (best == all.size() || key_of(all[i]) < key_of(all[best])))
            best = i;
    kept_.push_back(best);
}

/// The edges of the polygon around the kept points, as their lengths times the outward normals.
void PointChoice::find_edges()
{
    edges_.clear();
    for (const std::uint32_t u : kept_)
        for (const std::uint32_t v : kept_) {
            if (u == v) continue;
            const Vector2d way = flat_[v] - flat_[u], out(way.y(), -way.x());
            const auto inside = [&](std::uint32_t w) { return w == u || w == v || out.dot(flat_[w] - flat_[u]) <= 0; };
            if (std::ranges::all_of(kept_, inside)) edges_.emplace_back(flat_[u], out);
        }
}

const std::vector<std::uint32_t>& PointChoice::choose(const std::vector<ManifoldCandidate>& all, const Vector3d& normal,
                                                      std::size_t most)
{
    all_ = &all, flat_.clear(), kept_.clear(), values_.resize(all.size());
    const Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
    Vector2d low(unbounded, unbounded), high = -low, middle(0, 0);
    double deepest = -unbounded;
    for (const ManifoldCandidate& c : all) {
        flat_.emplace_back(u.dot(c.at), v.dot(c.at));
        low = low.cwiseMin(flat_.back()), high = high.cwiseMax(flat_.back()), middle += flat_.back();
        deepest = std::max(deepest, c.depth);
    }
    size_ = (high - low).norm(), middle /= double(all.size());
    const auto outermost = [&](std::size_t i) { // of the deepest
        return all[i].depth >= deepest - same_share * size_ ? (flat_[i] - middle).norm() : -1;
    };
    take(outermost, -unbounded, same_share * size_);
    if (most > 1) // the farthest
        take([&](std::size_t i) { return (flat_[i] - flat_[kept_[0]]).norm(); }, same_share * size_,
             same_share * size_);
    if (most > 2 && kept_.size() == 2) { // the largest triangle
        const Vector2d from = flat_[kept_[0]], way = flat_[kept_[1]] - from;
        const double least = same_share * size_ * way.norm();
        take([&](std::size_t i) { return std::abs(turn(way, flat_[i] - from)); }, least, least);
    }
    while (kept_.size() > 2 && kept_.size() < most) { // the most area added outside an edge
        const std::size_t before = kept_.size();
        find_edges();
        const auto outside = [&](std::size_t i) {
            double area = 0;
            for (const auto& [from, out] : edges_) area = std::max(area, out.dot(flat_[i] - from));
            return area;
        };
        take(outside, same_share * size_ * size_, same_share * size_ * size_);
        if (kept_.size() == before) break;
    }
    return kept_;
}

PointHull::PointHull(std::span<const ManifoldPoint> points)
{
    for (const ManifoldPoint& p : points) points_.push_back(middle_of(p));
    const std::size_t count = points_.size();
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = i + 1; j < count; ++j) {
            const Vector3d way = points_[j] - points_[i];
            const double length2 = way.squaredNorm();
            sides_.push_back({points_[i], way, length2 > 0 ? 1 / length2 : 0});
        }
    const std::size_t firsts = count > 6 ? 1 : count; // all triangles where they are few, else a fan
    for (std::size_t i = 0; i < firsts; ++i)
        for (std::size_t j = i + 1; j < count; ++j)
            for (std::size_t k = j + 1; k < count; ++k) {
                const Vector3d n = (points_[j] - points_[i]).cross(points_[k] - points_[i]);
                if (!(n.squaredNorm() > 0)) continue;
                Face face{n.normalized(), {}, {}, 0};
                const std::size_t corners[] = {i, j, k};
                for (int e = 0; e < 3; ++e) {
                    const Vector3d &from = points_[corners[e]], &to = points_[corners[(e + 1) % 3]];
                    face.inward[e] = face.normal.cross(to - from), face.least[e] = face.inward[e].dot(from);
                }
                face.height = face.normal.dot(points_[i]);
                faces_.push_back(face);
            }
}

double PointHull::distance2(const Vector3d& p, double enough) const
{
    double least = unbounded;
    for (const Vector3d& q : points_) least = std::min(least, (p - q).squaredNorm());
    for (const Face& f : faces_) {
        if (least <= enough) return least;
        if (f.inward[0].dot(p) < f.least[0] || f.inward[1].dot(p) < f.least[1] || f.inward[2].dot(p) < f.least[2])
            continue;
        const double height = f.normal.dot(p) - f.height;
        least = std::min(least, height * height);
    }
    for (const Side& s : sides_) {
        if (least <= enough) return least;
        const double at = std::clamp(s.way.dot(p - s.from) * s.inverse, 0.0, 1.0);
        least = std::min(least, (p - s.from - at * s.way).squaredNorm());
    }
    return least;
}

double angle_between(const Vector3d& u, const Vector3d& v)
{
    const double angle = std::atan2(u.cross(v).norm(), u.dot(v));
    return u.isZero(0) || v.isZero(0) ? std::numbers::pi : angle;
}

std::size_t most_regions(const ManifoldOptions& options)
{
    const std::size_t points = std::max(options.points_per_region, 1u);
    return std::max<std::size_t>(std::min<std::size_t>(options.regions_per_pair, options.points_per_pair / points), 1);
}

namespace {

/// Finds whether the region is curved. Drops candidates that face nothing, or are too shallow, if others are left.
void drop_idle(RegionDraft& draft, bool resolved)
{
    auto& all = draft.candidates;
    if (std::ranges::any_of(all, &ManifoldCandidate::opposite))
        std::erase_if(all, [](const auto& c) { return !c.opposite; });
    const auto known = [](const ManifoldCandidate& c) { return !c.normal.isZero(0); };
    constexpr double flat = 0.9994; // 2 degrees
    const auto differs = [&](const ManifoldCandidate& c) {
        const double cosine = c.normal.dot(draft.region.normal);
        return known(c) && cosine < flat && (resolved || c.of == ManifoldCandidate::of_both || cosine > facing_cosine);
    };
    draft.curved = std::ranges::any_of(all, differs);
    const auto faces = [&](const ManifoldCandidate& c) { return c.normal.dot(draft.region.normal) >= facing_cosine; };
    if (draft.curved && std::ranges::any_of(all, faces)) std::erase_if(all, [&](const auto& c) { return !faces(c); });
    const auto deep = [&](const ManifoldCandidate& c) { return c.depth >= draft.least_depth; };
    if (std::ranges::any_of(all, deep)) std::erase_if(all, [&](const auto& c) { return !deep(c); });
}

/// Estimates depths as if the surfaces were flat beside their common curve.
void estimate_depths(std::vector<ManifoldCandidate>& all, const Vector3d& n)
{
    double height = 0, points = 0;
    for (const ManifoldCandidate& c : all)
        if (c.of == ManifoldCandidate::of_both) height += n.dot(c.at), ++points;
    for (ManifoldCandidate& c : all)
        if (c.of != ManifoldCandidate::of_both && points > 0)
            c.depth = (c.of == ManifoldCandidate::of_a ? 1 : -1) * (n.dot(c.at) - height / points);
}

/// A lower bound of the way along a direction from a point inside a surface to the surface; at most `most`. The faces
/// of a region do not suffice: the way may leave the overlap, and the other body elsewhere.
double way_out(ManifoldMemory& memory, const PlacedSurface& surface, const Vector3d& from, const Vector3d& along,
               double most)
{
    const Segment way{surface.placed_back(from), surface.placed_back(from + most * along)};
    double least = 1;
    const auto take = [&](const TrianglePoints& face) {
        if (const auto entry = entry_of(way, face)) least = std::min(least, entry->lower);
        return least;
    };
    surface.with_tree([&](auto& tree) {
        if constexpr (requires { tree.corners(0); })
            memory.ways_out.walk(tree, way, [&](std::uint32_t triangle) { return take(tree.corners(triangle)); });
        else
            memory.ways_out_of_terrain.walk(tree, way,
                                            [&](std::uint32_t triangle) { return take(tree.points(triangle)); });
    });
    return least * most;
}

/// Finds the face opposite to a candidate along the region's normal, and with it the depth and the point's normal.
/// @param all_angles  faces at large angles count as opposite, too
void resolve(ManifoldMemory& memory, const PlacedSurface& a, const PlacedSurface& b, bool all_angles,
             ManifoldCandidate& c)
{
    if (c.of == ManifoldCandidate::of_both || (c.a && c.b)) return;
    const RegionDraft& draft = memory.draft;
    const bool of_a = c.of == ManifoldCandidate::of_a;
    double depth;
    if (const auto* found = (of_a ? memory.ahead_b : memory.ahead_a).nearest(c.at, depth)) {
        c.depth = depth, c.error = draft.rounding * found->error;
        const Vector3d across = (of_a ? 1 : -1) * found->depth.normalized(); // of the face, from a to b
        c.normal = of_a ? normal_across(c.normal, across) : normal_across(across, c.normal);
        if (all_angles && c.normal.isZero(0)) c.normal = across;
        (of_a ? c.b : c.a) = (of_a ? b : a).face(found->triangle);
    } else { // as at the end of a region
        c.depth = 0, c.error = draft.region.depth_upper + draft.rounding, c.opposite = false;
        if (c.normal.dot(draft.region.normal) < facing_cosine) c.normal.setZero();
    }
}

/// The candidates to keep. On a curved region, drops candidates found to face nothing, and chooses again.
std::span<const std::uint32_t> choose_resolved(ManifoldMemory& memory, const PlacedSurface& a, const PlacedSurface& b,
                                               std::size_t most)
{
    auto& all = memory.draft.candidates;
    const bool curved = memory.draft.curved;
    for (;;) {
        const auto& kept = memory.choice.choose(all, memory.draft.region.normal, most);
        for (const std::uint32_t i : kept) resolve(memory, a, b, !curved, all[i]);
        const auto idle = [](const ManifoldCandidate& c) { return !c.opposite || c.normal.isZero(0); };
        if (!curved || std::ranges::none_of(kept, [&](std::uint32_t i) { return idle(all[i]); }) ||
            std::ranges::all_of(all, idle))
            return kept;
        std::erase_if(all, idle);
    }
}

/// The point of a chosen candidate. Raises the bounds of the region's depth.
ManifoldPoint point_of(ManifoldMemory& memory, const PlacedSurface& a, const PlacedSurface& b,
                       const ManifoldCandidate& c)
{
    ManifoldRegion& region = memory.draft.region;
    const double rounding = memory.draft.rounding;
    const Vector3d n = region.normal;
    const bool of_a = c.of == ManifoldCandidate::of_a, of_b = c.of == ManifoldCandidate::of_b;
    // Support points of a round solid are on its true surface.
    const double off = (of_a && a.round() ? 0 : a.error()) + (of_b && b.round() ? 0 : b.error());
    constexpr double least_cosine = std::numbers::sqrt2 / 2; // 45 degrees
    const Vector3d normal = c.normal.dot(n) >= least_cosine ? c.normal : n;
    ManifoldPoint p{c.at, c.at, c.depth, c.error + rounding + off, c.a, c.b, normal};
    double deep = p.depth - p.depth_error;
    if (const PlacedSurface& other = of_a ? b : a;
        deep > std::max(region.depth_lower, 0.0) && other.solid() && (of_a || of_b)) {
        const double out = way_out(memory, other, c.at, (of_a ? -1 : 1) * n, deep);
        if (memory.draft.curved && out < 0.999 * deep) p.depth = out; // through a face of another region
        deep = out - rounding;
    }
    if (of_a) p.point_b = c.at - p.depth * n;
    if (of_b) p.point_a = c.at + p.depth * n;
    region.depth_upper = std::max(region.depth_upper, p.depth - p.depth_error);
    region.depth_lower = std::max(region.depth_lower, deep);
    return p;
}

/// Gives all points of a flat region its normal: solvers do not bring a body to rest between normals that differ a
/// little.
void level(std::span<ManifoldPoint> points, const Vector3d& normal)
{
    constexpr double flat = 1e-3; // radians
    const auto level = [&](const ManifoldPoint& p) { return p.normal.cross(normal).norm() <= flat; };
    if (std::ranges::all_of(points, level))
        for (ManifoldPoint& p : points) p.normal = normal;
}

} // namespace

void finish(ManifoldMemory& memory, const PlacedSurface& a, const PlacedSurface& b, const ManifoldOptions& options,
            Manifold& manifold)
{
    RegionDraft& draft = memory.draft;
    ManifoldRegion& region = draft.region;
    auto& all = draft.candidates;
    memory.ahead_a.set(draft.faces_a, region.normal), memory.ahead_b.set(draft.faces_b, -region.normal);
    constexpr std::size_t most_rays = 1 << 10;
    const bool early = all.size() * (draft.faces_a.size() + draft.faces_b.size()) <= most_rays;
    if (early)
        for (ManifoldCandidate& c : all) resolve(memory, a, b, false, c);
    drop_idle(draft, early);
    if (all.empty()) return;
    if (!early) estimate_depths(all, region.normal);
    region.first = static_cast<std::uint32_t>(manifold.points.size());
    region.found = static_cast<std::uint32_t>(all.size());
    region.depth_lower = -unbounded;
    const std::size_t most = std::max(options.points_per_region, 1u);
    for (const std::uint32_t i :
         early ? memory.choice.choose(all, region.normal, most) : choose_resolved(memory, a, b, most))
        manifold.points.push_back(point_of(memory, a, b, all[i]));
    region.count = static_cast<std::uint32_t>(manifold.points.size()) - region.first;
    if (region.kind != RegionKind::near) region.depth_lower = std::max(region.depth_lower, 0.0);
    region.depth_upper = std::max(region.depth_upper, region.depth_lower);
    const auto points = std::span(manifold.points).subspan(region.first);
    level(points, region.normal);
    const PointHull hull(points);
    double lost = 0;
    for (const Vector3d& p : draft.contacts) lost = std::max(lost, hull.distance2(p, lost));
    region.lost = std::sqrt(lost) + draft.rounding;
    manifold.regions.push_back(region);
}

} // namespace oncollide
