#include <oncollide/narrowphase/pairs/manifolds/touching_regions.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/pairs/manifolds/common_polygon.hpp>

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
    Vector3d normal; ///< unit, from a to b
    double area = 0; ///< area of the common polygon
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
        m.normal = between.norm() > manifold_limits::least_direction ? Vector3d(between.normalized()) : of_a;
        const auto edge = [](const TrianglePoints& t, unsigned place) -> Vector3d {
            return place == 3 ? t[1] - t[0] : place == 6 ? t[2] - t[1] : t[0] - t[2];
        };
        if (std::popcount(in_a) == 2 && std::popcount(in_b) == 2) {
            const Vector3d u = edge(a, in_a).normalized(), v = edge(b, in_b).normalized(), n = u.cross(v);
            if (n.norm() > manifold_limits::least_direction)
                m.rank = Rank::edges, m.normal = (n.dot(between) < 0 ? Vector3d(-n) : n).normalized();
        }
    }
    return m;
}

/// Groups of meetings that share triangles or points of a mesh.
std::vector<std::vector<const Meeting*>> connected(const std::vector<Meeting>& meetings, const ManifoldJob& job,
                                                   KeyNumbers& vertices)
{
    std::vector<std::uint32_t> roots(meetings.size());
    std::iota(roots.begin(), roots.end(), 0u);
    const auto root_of = [&](std::uint32_t i) {
        while (roots[i] != i) i = roots[i] = roots[roots[i]];
        return i;
    };
    std::vector<std::uint32_t> first; // the first meeting at each vertex
    // On a common plane many faces of both meet; a large face of one does not connect meetings far apart on it.
    for (const int side : {0, 1}) {
        vertices.clear(), first.clear();
        for (std::uint32_t i = 0; i < meetings.size(); ++i)
            for (const std::uint32_t v :
                 job.surface(side).corners(side == 0 ? meetings[i].pair.a : meetings[i].pair.b)) {
                bool is_new;
                const std::uint32_t number = vertices.add(v, is_new);
                if (is_new) first.push_back(i);
                const std::uint32_t x = root_of(i), y = root_of(first[number]);
                roots[std::max(x, y)] = std::min(x, y);
            }
    }
    std::vector<std::vector<const Meeting*>> groups(meetings.size());
    for (std::uint32_t i = 0; i < meetings.size(); ++i) groups[root_of(i)].push_back(&meetings[i]);
    std::erase_if(groups, [](const auto& g) { return g.empty(); });
    return groups;
}

void add_region(const ManifoldJob& job, RegionMaker& maker, const std::vector<const Meeting*>& meetings,
                std::span<const Meeting* const> others)
{
    const PlacedSurface &a = job.a, &b = job.b;
    RegionDraft& draft = maker.draft;
    draft.begin(RegionKind::touching, !job.solid(), job.rounding);
    ManifoldRegion& region = draft.region;
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
    const double weights = region.area > 0 ? region.area : double(meetings.size());
    const bool known = sum.norm() > manifold_limits::least_direction * weights;
    region.normal = known ? Vector3d(sum.normalized()) : Vector3d::UnitX();
    region.normal_error = known ? 0x1p-40 : std::numbers::pi;
    for (const Meeting* m : meetings)
        if (known)
            region.normal_error = std::max(region.normal_error, angle_between(m->normal, region.normal) + 0x1p-40);
    region.centre = region.area > 0 ? Vector3d(moment / region.area) : box.centre();
    region.depth_upper = 4 * draft.rounding + a.error() + b.error();
    maker.finish(job);
}

} // namespace

/// Returns the pairs that meet away from lumps with a volume. It leaves out pairs of such a lump's triangles, or of
/// their neighbours, near the lump's curve.
std::vector<TrianglePair> TouchingRegions::other_pairs(const ManifoldJob& job, std::span<const TrianglePair> meeting,
                                                       const OverlapPatches& overlap)
{
    std::vector<TrianglePair> rest;
    const auto has_volume = [&](std::uint32_t lump) { return overlap.lumps[lump].has_volume(job.rounding); };
    for (std::size_t i = 0; i < meeting.size(); ++i)
        if (const std::uint32_t patch = overlap.crossing[i];
            patch == OverlapPatches::none || !has_volume(overlap.patches[0][patch].lump))
            rest.push_back(meeting[i]);
    if (rest.empty() || overlap.lumps.empty()) return rest;
    const double slack = 16 * job.rounding;
    for (const int side : {0, 1}) {
        vertices_.clear(), lump_of_.clear();
        for (const Patch& p : overlap.patches[side])
            if (has_volume(p.lump))
                for (const std::uint32_t v : p.corners) {
                    bool is_new;
                    vertices_.add(v, is_new), lump_of_.resize(vertices_.count(), p.lump);
                }
        if (vertices_.count() == 0) continue;
        std::erase_if(rest, [&](const TrianglePair& pair) {
            Aabb of_a, of_b;
            for (const Vector3d& p : job.a.points(pair.a)) of_a.add(p);
            for (const Vector3d& p : job.b.points(pair.b)) of_b.add(p);
            const Aabb common{of_a.min.cwiseMax(of_b.min).array() - slack, of_a.max.cwiseMin(of_b.max).array() + slack};
            return std::ranges::any_of(job.surface(side).corners(side == 0 ? pair.a : pair.b), [&](std::uint32_t v) {
                const std::uint32_t number = vertices_.find(v);
                return number != KeyNumbers::none && overlap.lumps[lump_of_[number]].box.overlaps(common);
            });
        });
    }
    return rest;
}

void TouchingRegions::add(const ManifoldJob& job, std::span<const TrianglePair> meeting, const OverlapPatches& overlap,
                          RegionMaker& maker)
{
    std::vector<Meeting> meetings;
    for (const TrianglePair& pair : other_pairs(job, meeting, overlap))
        meetings.push_back(meeting_of(pair, job.a.points(pair.a), job.b.points(pair.b), 4 * job.rounding));
    for (const auto& group : connected(meetings, job, vertices_)) {
        const Rank best = (*std::ranges::max_element(group, {}, [](const Meeting* m) { return m->rank; }))->rank;
        std::vector<std::vector<const Meeting*>> directions;
        std::vector<const Meeting*> others;
        for (const Meeting* m : group) {
            if (m->rank != best) {
                others.push_back(m);
                continue;
            }
            const auto at = std::ranges::find_if(directions, [&](const auto& d) {
                return best < Rank::face || angle_between(d.front()->normal, m->normal) <= job.options.normal_spread;
            });
            if (at == directions.end())
                directions.push_back({m});
            else
                at->push_back(m);
        }
        for (const auto& direction : directions) {
            add_region(job, maker, direction, others);
            others.clear(); // they count for the first region
        }
    }
}

} // namespace oncollide
