// Chooses the points of a region.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include <oncollide/narrowphase/pairs/manifolds/region_draft.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

constexpr double same = 1e-6; ///< share of a region's size that no point needs to be apart

/// The nearest of the faces that the line p + t direction crosses outward, as seen from the body that the faces bound.
struct Opposite {
    double depth = unbounded, error = unbounded;
    std::uint32_t triangle = 0;
};
Opposite opposite_of(const Vector3d& p, const Vector3d& direction, double rounding,
                     const std::vector<std::pair<std::uint32_t, TrianglePoints>>& faces)
{
    Opposite best;
    for (const auto& [number, t] : faces) {
        const Vector3d u = t[1] - t[0], v = t[2] - t[0], n = u.cross(v);
        const double length = n.norm(), slope = direction.dot(n);
        if (!(slope > 1e-6 * length)) continue;
        const double depth = n.dot(t[0] - p) / slope;
        const Vector3d w = p + depth * direction - t[0];
        const double s = n.dot(w.cross(v)) / (length * length), r = n.dot(u.cross(w)) / (length * length);
        if (s < -1e-9 || r < -1e-9 || s + r > 1 + 1e-9) continue;
        if (std::abs(depth) < std::abs(best.depth)) best = {depth, rounding * length / slope, number};
    }
    return best;
}

/// Squared distance of a point from a triangle.
double distance2(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c)
{
    const auto from_segment = [&](const Vector3d& u, const Vector3d& v) {
        const Vector3d d = v - u;
        const double length2 = d.squaredNorm(), at = length2 > 0 ? std::clamp(d.dot(p - u) / length2, 0.0, 1.0) : 0;
        return (p - u - at * d).squaredNorm();
    };
    double least = std::min({from_segment(a, b), from_segment(b, c), from_segment(c, a)});
    const Vector3d n = (b - a).cross(c - a);
    if (const double n2 = n.squaredNorm(); n2 > 0) {
        const auto side = [&](const Vector3d& u, const Vector3d& v) { return n.dot((v - u).cross(p - u)) >= 0; };
        if (side(a, b) && side(b, c) && side(c, a)) least = std::min(least, std::pow(n.dot(p - a), 2) / n2);
    }
    return least;
}

/// Indices of the candidates to keep, the deepest first.
class Choice {
public:
    Choice(const std::vector<ManifoldCandidate>& all, const Vector3d& normal, std::size_t most)
        : all_(all), normal_(normal)
    {
        for (const ManifoldCandidate& c : all) flat_.push_back(c.at - normal.dot(c.at) * normal);
        Aabb box;
        for (const Vector3d& p : flat_) box.add(p);
        size_ = box.diagonal();
        Vector3d middle = Vector3d::Zero();
        for (const Vector3d& p : flat_) middle += p / double(flat_.size());
        double deepest = -unbounded;
        for (const ManifoldCandidate& c : all) deepest = std::max(deepest, c.depth);
        const auto outermost = [&](std::size_t i) { // of the deepest
            return all_[i].depth >= deepest - same * size_ ? (flat_[i] - middle).norm() : -1;
        };
        take(outermost, -unbounded, same * size_);
        if (most > 1) // the farthest
            take([&](std::size_t i) { return (flat_[i] - kept_point(0)).norm(); }, same * size_, same * size_);
        const auto area = [&](std::size_t i) {
            return normal_.dot((kept_point(1) - kept_point(0)).cross(flat_[i] - kept_point(0)));
        };
        if (most > 2 && kept_.size() == 2) { // the largest triangle
            const double least = same * size_ * (kept_point(1) - kept_point(0)).norm();
            take([&](std::size_t i) { return std::abs(area(i)); }, least, least);
        }
        while (kept_.size() > 2 && kept_.size() < most) { // the most area added
            const std::size_t before = kept_.size();
            find_edges();
            take([&](std::size_t i) { return outside(i); }, same * size_ * size_, same * size_ * size_);
            if (kept_.size() == before) break;
        }
    }
    const std::vector<std::size_t>& kept() const { return kept_; }

private:
    const Vector3d& kept_point(std::size_t k) const { return flat_[kept_[k]]; }
    /// Keeps the candidate of the largest value above `least`; of nearly equal ones the deepest, then the first.
    void take(auto value, double least, double tie)
    {
        double most = -unbounded;
        for (std::size_t i = 0; i < all_.size(); ++i) most = std::max(most, value(i));
        if (!(most > least) && !kept_.empty()) return;
        std::size_t best = all_.size();
        for (std::size_t i = 0; i < all_.size(); ++i)
            if (value(i) >= most - tie && (best == all_.size() || all_[i].depth > all_[best].depth + 1e-9 * size_))
                best = i;
        kept_.push_back(best);
    }
    /// The edges of the polygon around the kept points, as their lengths times the outward normals.
    void find_edges()
    {
        edges_.clear();
        for (std::size_t u = 0; u < kept_.size(); ++u)
            for (std::size_t v = 0; v < kept_.size(); ++v) {
                if (u == v) continue;
                const Vector3d out = (kept_point(v) - kept_point(u)).cross(normal_);
                bool all_inside = true;
                for (std::size_t w = 0; w < kept_.size(); ++w)
                    all_inside &= w == u || w == v || out.dot(kept_point(w) - kept_point(u)) <= 0;
                if (all_inside) edges_.emplace_back(kept_point(u), out);
            }
    }
    /// The largest area that the point adds outside an edge.
    double outside(std::size_t i) const
    {
        double most = 0;
        for (const auto& [from, out] : edges_) most = std::max(most, out.dot(flat_[i] - from));
        return most;
    }

    const std::vector<ManifoldCandidate>& all_;
    const Vector3d& normal_;
    std::vector<Vector3d> flat_;
    std::vector<std::size_t> kept_;
    std::vector<std::pair<Vector3d, Vector3d>> edges_;
    double size_ = 0;
};

/// Squared distance of a point from the hull of points: at most that from the triangles tried.
double hull_distance2(const Vector3d& p, std::span<const Vector3d> points)
{
    double least = unbounded;
    const std::size_t count = points.size();
    if (count < 3) return distance2(p, points.front(), points.back(), points.back());
    const std::size_t firsts = count > 6 ? 1 : count; // all triangles where they are few, else a fan
    for (std::size_t i = 0; i < firsts; ++i)
        for (std::size_t j = i + 1; j < count; ++j)
            for (std::size_t k = j + 1; k < count && least > 0; ++k)
                least = std::min(least, distance2(p, points[i], points[j], points[k]));
    return least;
}

double farthest_lost(const RegionDraft& draft, std::span<const ManifoldPoint> kept)
{
    std::vector<Vector3d> points;
    for (const ManifoldPoint& p : kept) points.push_back(middle_of(p));
    double lost = 0;
    for (const Vector3d& p : draft.contacts) {
        double nearest = unbounded; // a point of the hull: mostly near enough to decide
        for (const Vector3d& q : points) nearest = std::min(nearest, (p - q).squaredNorm());
        if (nearest > lost) lost = std::max(lost, hull_distance2(p, points));
    }
    return std::sqrt(lost) + draft.rounding;
}

} // namespace

double distance_from_hull(const Vector3d& point, std::span<const ManifoldPoint> hull)
{
    std::vector<Vector3d> points;
    for (const ManifoldPoint& p : hull) points.push_back(middle_of(p));
    return std::sqrt(hull_distance2(point, points));
}

double angle_between(const Vector3d& u, const Vector3d& v)
{
    const double angle = std::atan2(u.cross(v).norm(), u.dot(v));
    return u.isZero(0) || v.isZero(0) ? std::numbers::pi : angle;
}

void finish(RegionDraft& draft, const PlacedSurface& a, const PlacedSurface& b, const ManifoldOptions& options,
            Manifold& manifold)
{
    auto& all = draft.candidates;
    const Vector3d n = draft.region.normal;
    // One of each two features; sorted, so that ties do not depend on the order in which pairs were found.
    const auto key = [&](const ManifoldCandidate& c) {
        return std::tuple(c.a, c.b, c.of, c.at.x(), c.at.y(), c.at.z());
    };
    std::ranges::sort(all, {}, key);
    all.erase(std::unique(all.begin(), all.end(), [&](const auto& x, const auto& y) { return key(x) == key(y); }),
              all.end());
    const auto resolve = [&](ManifoldCandidate& c) {
        if (c.of == ManifoldCandidate::of_both) return;
        const bool of_a = c.of == ManifoldCandidate::of_a;
        const Opposite found =
            opposite_of(c.at, of_a ? Vector3d(-n) : n, draft.rounding, of_a ? draft.faces_b : draft.faces_a);
        if (found.depth < unbounded) {
            c.depth = found.depth, c.error = found.error;
            (of_a ? c.b : c.a) = (of_a ? b : a).face(found.triangle);
        } else {
            c.depth = 0, c.error = draft.region.depth_upper + draft.rounding, c.opposite = false;
        }
    };
    constexpr std::size_t most_rays = 1 << 10;
    const bool early = all.size() * (draft.faces_a.size() + draft.faces_b.size()) <= most_rays;
    if (early) {
        std::ranges::for_each(all, resolve);
        if (std::ranges::any_of(all, &ManifoldCandidate::opposite))
            std::erase_if(all, [](const auto& c) { return !c.opposite; });
        if (std::ranges::any_of(all, [&](const auto& c) { return c.depth >= draft.least_depth; }))
            std::erase_if(all, [&](const auto& c) { return c.depth < draft.least_depth; });
    }
    if (all.empty()) return;
    if (!early) { // as if the surfaces were flat beside their common curve
        double height = 0, points = 0;
        for (const ManifoldCandidate& c : all)
            if (c.of == ManifoldCandidate::of_both) height += n.dot(c.at), ++points;
        for (ManifoldCandidate& c : all)
            if (c.of != ManifoldCandidate::of_both && points > 0)
                c.depth = (c.of == ManifoldCandidate::of_a ? 1 : -1) * (n.dot(c.at) - height / points);
    }
    const Choice choice(all, n, std::max(options.points_per_region, 1u));
    ManifoldRegion& region = draft.region;
    region.first = static_cast<std::uint32_t>(manifold.points.size());
    region.found = static_cast<std::uint32_t>(all.size());
    region.depth_lower = -unbounded;
    for (const std::size_t i : choice.kept()) {
        ManifoldCandidate c = all[i];
        if (!early) resolve(c);
        // Support points of a round solid are on its true surface.
        const double off = (c.of == ManifoldCandidate::of_a && a.round() ? 0 : a.error()) +
                           (c.of == ManifoldCandidate::of_b && b.round() ? 0 : b.error());
        ManifoldPoint p{c.at, c.at, c.depth, c.error + draft.rounding + off, c.a, c.b};
        if (c.of == ManifoldCandidate::of_a) p.point_b = c.at - c.depth * n;
        if (c.of == ManifoldCandidate::of_b) p.point_a = c.at + c.depth * n;
        region.depth_lower = std::max(region.depth_lower, p.depth - p.depth_error);
        manifold.points.push_back(p);
    }
    region.count = static_cast<std::uint32_t>(manifold.points.size()) - region.first;
    if (region.kind != RegionKind::near) region.depth_lower = std::max(region.depth_lower, 0.0);
    region.depth_upper = std::max(region.depth_upper, region.depth_lower);
    region.lost = farthest_lost(draft, std::span(manifold.points).subspan(region.first));
    manifold.regions.push_back(region);
}

} // namespace oncollide
