// Regions of surfaces that meet without a common volume.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/pairs/manifolds/common_polygon.hpp>
#include <oncollide/narrowphase/pairs/manifolds/region_draft.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

/// How well a meeting defines a normal.
enum class Rank : std::uint8_t { corner, edges, face, area };

/// The place of a point in a triangle: bit k is set for the corners that span its feature.
unsigned place_in(const TrianglePoints& t, const Vector3d& p, double rounding)
{
    for (int k = 0; k < 3; ++k)
        if ((p - t[k]).norm() <= rounding) return 1u << k;
    for (int k = 0; k < 3; ++k) {
        const Vector3d d = t[(k + 1) % 3] - t[k];
        if (d.cross(p - t[k]).norm() <= rounding * d.norm()) return 1u << k | 1u << (k + 1) % 3;
    }
    return 7;
}

FeatureBits feature_of(const PlacedSurface& surface, std::uint32_t triangle, unsigned place)
{
    const auto corners = surface.corners(triangle);
    std::vector<std::uint32_t> spanned;
    for (int k = 0; k < 3; ++k)
        if (place >> k & 1) spanned.push_back(corners[k]);
    if (spanned.size() == 3) return surface.face(triangle);
    return spanned.size() == 2 ? surface.edge(spanned[0], spanned[1]) : surface.vertex(spanned[0]);
}

/// One meeting pair of triangles.
struct Meeting {
    TrianglePair pair;
    Rank rank;
    Vector3d normal; ///< from a to b
    double area = 0; ///< of the common polygon
    Vector3d moment = Vector3d::Zero();
    std::vector<Vector3d> points; ///< corners of the overlap of the triangles
};

Meeting meeting_of(TrianglePair pair, const TrianglePoints& a, const TrianglePoints& b, double rounding)
{
    Meeting m{.pair = pair, .rank = Rank::corner, .normal = Vector3d::Zero(), .points = {}};
    const Vector3d of_a = unit_normal(a[0], a[1], a[2]), of_b = unit_normal(b[0], b[1], b[2]);
    if (!of_a.isZero(0) && !of_b.isZero(0) && in_one_plane(a, b)) {
        m.points = common_polygon(a, b, of_a);
        for (std::size_t i = 2; i < m.points.size(); ++i) {
            const Vector3d &o = m.points[0], &u = m.points[i - 1], &v = m.points[i];
            const double area = 0.5 * of_a.dot((u - o).cross(v - o));
            m.area += area, m.moment += area / 3 * (o + u + v);
        }
        if (m.area > 0 && of_a.dot(of_b) < 0) {
            m.rank = Rank::area, m.normal = (of_a - of_b).normalized();
            return m;
        }
        m.area = 0, m.moment.setZero(), m.points.clear();
    }
    const CommonSegment common = common_segment(a, b);
    m.points.assign(common.ends.begin(), common.ends.end());
    const Vector3d middle = 0.5 * (common.ends[0] + common.ends[1]);
    const unsigned in_a = place_in(a, middle, rounding), in_b = place_in(b, middle, rounding);
    if (in_a == 7 && !of_a.isZero(0) && in_b != 7) {
        m.rank = Rank::face, m.normal = of_a;
    } else if (in_b == 7 && !of_b.isZero(0) && in_a != 7) {
        m.rank = Rank::face, m.normal = -of_b;
    } else {
        const Vector3d between = of_a - of_b;
        m.normal = between.norm() > 1e-6 ? Vector3d(between.normalized()) : of_a;
        const auto edge = [](const TrianglePoints& t, unsigned place) -> Vector3d {
            return place == 3 ? t[1] - t[0] : place == 6 ? t[2] - t[1] : t[0] - t[2];
        };
        if (std::popcount(in_a) == 2 && std::popcount(in_b) == 2) {
            const Vector3d u = edge(a, in_a).normalized(), v = edge(b, in_b).normalized(), n = u.cross(v);
            if (n.norm() > 1e-6) m.rank = Rank::edges, m.normal = (n.dot(between) < 0 ? Vector3d(-n) : n).normalized();
        }
    }
    return m;
}

/// Groups of meetings that share triangles or points of a mesh.
std::vector<std::vector<const Meeting*>> connected(const std::vector<Meeting>& meetings, const PlacedSurface& a,
                                                   const PlacedSurface& b)
{
    std::vector<std::uint32_t> roots(meetings.size());
    std::iota(roots.begin(), roots.end(), 0u);
    const auto root_of = [&](std::uint32_t i) {
        while (roots[i] != i) i = roots[i] = roots[roots[i]];
        return i;
    };
    KeyNumbers vertices;
    std::vector<std::uint32_t> first; // the first meeting at each vertex
    const auto join_all = [&](const PlacedSurface& surface, bool of_a) {
        vertices.clear(), first.clear();
        for (std::uint32_t i = 0; i < meetings.size(); ++i)
            for (const std::uint32_t v : surface.corners(of_a ? meetings[i].pair.a : meetings[i].pair.b)) {
                bool is_new;
                const std::uint32_t number = vertices.add(v, is_new);
                if (is_new) first.push_back(i);
                const std::uint32_t x = root_of(i), y = root_of(first[number]);
                roots[std::max(x, y)] = std::min(x, y);
            }
    };
    // On a common plane many faces of both meet; a large face of one does not connect meetings far apart on it.
    join_all(a, true), join_all(b, false);
    std::vector<std::vector<const Meeting*>> groups(meetings.size());
    for (std::uint32_t i = 0; i < meetings.size(); ++i) groups[root_of(i)].push_back(&meetings[i]);
    std::erase_if(groups, [](const auto& g) { return g.empty(); });
    return groups;
}

void add_region(ManifoldMemory& memory, const std::vector<const Meeting*>& meetings,
                std::span<const Meeting* const> others, const PlacedSurface& a, const PlacedSurface& b,
                const ManifoldOptions& options, Manifold& manifold)
{
    RegionDraft& draft = memory.draft;
    draft.clear();
    draft.rounding = rounding_of(a, b);
    ManifoldRegion& region = draft.region;
    region.kind = RegionKind::touching, region.open = !a.solid() || !b.solid();
    Vector3d sum = Vector3d::Zero(), moment = Vector3d::Zero();
    Aabb box;
    for (const Meeting* m : meetings) {
        sum += (m->rank == Rank::area ? m->area : 1.0) * m->normal, moment += m->moment, region.area += m->area;
        for (const Vector3d& p : m->points) {
            box.add(p), draft.contacts.push_back(p);
            const auto feature = [&](const PlacedSurface& s, std::uint32_t t) {
                return feature_of(s, t, place_in(s.points(t), p, 4 * draft.rounding));
            };
            draft.add_shared({p, ManifoldCandidate::of_both, feature(a, m->pair.a), feature(b, m->pair.b)});
        }
    }
    for (const Meeting* m : others) draft.contacts.insert(draft.contacts.end(), m->points.begin(), m->points.end());
    const bool known = sum.norm() > 1e-6 * (region.area > 0 ? region.area : double(meetings.size()));
    region.normal = known ? Vector3d(sum.normalized()) : Vector3d::UnitX();
    region.normal_error = known ? 0x1p-40 : std::numbers::pi;
    for (const Meeting* m : meetings)
        if (known)
            region.normal_error = std::max(region.normal_error, angle_between(m->normal, region.normal) + 0x1p-40);
    region.centre = region.area > 0 ? Vector3d(moment / region.area) : box.centre();
    region.depth_upper = 4 * draft.rounding + a.error() + b.error();
    finish(memory, a, b, options, manifold);
}

} // namespace

void add_touching_regions(ManifoldMemory& memory, std::span<const TrianglePair> pairs, const PlacedSurface& a,
                          const PlacedSurface& b, const ManifoldOptions& options, Manifold& manifold)
{
    std::vector<Meeting> meetings;
    const double rounding = 4 * rounding_of(a, b);
    for (const TrianglePair& pair : pairs)
        meetings.push_back(meeting_of(pair, a.points(pair.a), b.points(pair.b), rounding));
    for (const auto& group : connected(meetings, a, b)) {
        const Rank best = (*std::ranges::max_element(group, {}, [](const Meeting* m) { return m->rank; }))->rank;
        std::vector<std::vector<const Meeting*>> directions;
        std::vector<const Meeting*> others;
        for (const Meeting* m : group) {
            if (m->rank != best) {
                others.push_back(m);
                continue;
            }
            const auto at = std::ranges::find_if(directions, [&](const auto& d) {
                return best < Rank::face || angle_between(d.front()->normal, m->normal) <= options.normal_spread;
            });
            if (at == directions.end())
                directions.push_back({m});
            else
                at->push_back(m);
        }
        for (const auto& direction : directions)
            add_region(memory, direction,
                       &direction == &directions.front() ? std::span<const Meeting* const>(others)
                                                         : std::span<const Meeting* const>(),
                       a, b, options, manifold);
    }
}

} // namespace oncollide
