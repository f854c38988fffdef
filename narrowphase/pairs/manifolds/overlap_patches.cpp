#include <oncollide/narrowphase/pairs/manifolds/overlap_patches.hpp>

#include <algorithm>
#include <limits>
#include <numeric>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/moved_apart.hpp>
#include <oncollide/narrowphase/pairs/manifolds/common_polygon.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/manifold_limits.hpp>

namespace oncollide {

using Eigen::Vector3d;

/// The crossing of an edge of one triangle with the other triangle.
struct OverlapPatches::EdgeCrossing {
    bool of_a;
    int edge;
    bool outward; ///< the edge leaves the other body
    Vector3d at;
};

namespace {

/// Adds `times` the triangle (origin, u, v), where the origin is the patch's first corner.
inline void add_fan(Patch& patch, const Vector3d& u, const Vector3d& v, double times)
{
    const Vector3d& origin = patch.points[0];
    const double area = 0.5 * times * patch.normal.dot((u - origin).cross(v - origin));
    patch.area += area, patch.moment += area / 3 * (origin + u + v);
}

/// On which sides of the other triangle's plane the corners of a triangle are, and so where its edges may cross.
struct EdgeSides {
    std::array<int, 3> exact; ///< 0 for a corner in the plane
    std::array<int, 3> moved; ///< after the infinitely small move; 0 only for a plane without area

    EdgeSides(const TrianglePoints& t, const TrianglePoints& plane, bool of_a)
    {
        for (int k = 0; k < 3; ++k) {
            exact[k] = orient3d(plane[0], plane[1], plane[2], t[k]);
            moved[k] = moved_side(plane, exact[k], of_a);
        }
    }
    bool in_plane() const { return exact[0] == 0 && exact[1] == 0 && exact[2] == 0; }
    bool on_one_side() const { return moved[0] == moved[1] && moved[0] == moved[2]; }
    bool cross(int edge) const { return moved[edge] * moved[(edge + 1) % 3] < 0; }
    /// The point at which an edge crosses the plane.
    Vector3d crossing(const TrianglePoints& t, const TrianglePoints& plane, int edge) const
    {
        const int from = exact[edge], to = exact[(edge + 1) % 3];
        const Vector3d &p = t[edge], &q = t[(edge + 1) % 3];
        const double at = from == 0    ? 0
                          : to == 0    ? 1
                          : from == to ? 0.5
                                       : crossing_parameter(plane[0], plane[1], plane[2], p, q);
        return p + at * (q - p);
    }
};

/// The directions in which the edges of a turn around the edges of b. Each turn is computed when it is first needed.
class EdgeTurns {
public:
    EdgeTurns(const TrianglePoints& a, const TrianglePoints& b) : a_(a), b_(b) {}
    /// True if the line of an edge of one goes through the other.
    bool go_through(bool of_a, int edge)
    {
        const auto turn = [&](int other) { return of_a ? at(edge, other) : at(other, edge); };
        const int first = turn(0);
        return first != 0 && turn(1) == first && turn(2) == first;
    }

private:
    int at(int i, int k)
    {
        int& turn = turns_[i][k];
        if (turn == unknown) turn = moved_turn(a_[i], a_[(i + 1) % 3], b_[k], b_[(k + 1) % 3]);
        return turn;
    }

    static constexpr int unknown = 2;
    const TrianglePoints &a_, &b_;
    std::array<std::array<int, 3>, 3> turns_{
        {{unknown, unknown, unknown}, {unknown, unknown, unknown}, {unknown, unknown, unknown}}};
};

std::uint32_t root_of(std::vector<std::uint32_t>& roots, std::uint32_t i)
{
    while (roots[i] != i) i = roots[i] = roots[roots[i]];
    return i;
}

void join(std::vector<std::uint32_t>& roots, std::uint32_t i, std::uint32_t k)
{
    const std::uint32_t u = root_of(roots, i), v = root_of(roots, k);
    roots[std::max(u, v)] = std::min(u, v);
}

} // namespace

bool Lump::has_volume(double of_coordinates) const
{
    return open || !(volume <= manifold_limits::touching_roundings * of_coordinates * std::max(pieces_a, pieces_b));
}

void OverlapPatches::Windings::clear()
{
    numbers.clear(), parent.clear(), vertex.clear(), above.clear();
}

std::uint32_t OverlapPatches::Windings::node(std::uint32_t v)
{
    bool is_new;
    const std::uint32_t number = numbers.add(v, is_new);
    if (is_new) parent.push_back(number), above.push_back(0), vertex.push_back(v);
    return number;
}

std::pair<std::uint32_t, int> OverlapPatches::Windings::root(std::uint32_t n)
{
    int sum = 0;
    while (parent[n] != n) {
        const std::uint32_t up = parent[n];
        if (parent[up] != up) above[n] += above[up], parent[n] = parent[up]; // halves the path
        sum += above[n], n = parent[n];
    }
    return {n, sum};
}

/// False if the new difference contradicts the known ones.
bool OverlapPatches::Windings::join(std::uint32_t u, std::uint32_t v, int more_at_v)
{
    const auto [root_u, of_u] = root(u);
    const auto [root_v, of_v] = root(v);
    if (root_u == root_v) return of_v == of_u + more_at_v;
    const auto [low, high] = std::minmax(root_u, root_v);
    parent[high] = low;
    above[high] = high == root_v ? of_u + more_at_v - of_v : of_v - more_at_v - of_u;
    return true;
}

std::uint32_t OverlapPatches::patch(int side, std::uint32_t triangle, const TrianglePoints* points)
{
    bool is_new;
    const std::uint32_t number = patch_of_[side].add(triangle, is_new);
    if (is_new) {
        Patch& p = patches[side].emplace_back();
        p.triangle = triangle, p.corners = surfaces_[side]->corners(triangle);
        p.points = points ? *points : surfaces_[side]->points(triangle);
        p.normal = unit_normal(p.points[0], p.points[1], p.points[2]);
    }
    return number;
}

/// Adds the common segment of two triangles, if they cross.
void OverlapPatches::cross(std::uint32_t number, TrianglePair pair)
{
    const std::array<TrianglePoints, 2> t{surfaces_[0]->points(pair.a), surfaces_[1]->points(pair.b)};
    const std::array<EdgeSides, 2> sides{EdgeSides(t[0], t[1], true), EdgeSides(t[1], t[0], false)};
    if (sides[1].in_plane()) in_planes_.push_back(number);
    if (sides[0].on_one_side() || sides[1].on_one_side()) return;
    EdgeTurns turns(t[0], t[1]);
    std::array<EdgeCrossing, 2> ends; // the ends of the segment, as seen from a
    std::array<int, 2> found{};
    for (const int body : {0, 1})
        for (int edge = 0; edge < 3; ++edge) {
            if (!sides[body].cross(edge) || !turns.go_through(body == 0, edge)) continue;
            const bool outward = sides[body].moved[(edge + 1) % 3] > 0;
            const int end = outward == (body == 0) ? 0 : 1;
            ends[end] = {body == 0, edge, outward, sides[body].crossing(t[body], t[1 - body], edge)}, ++found[end];
        }
    if (found[0] == 1 && found[1] == 1) add_segment(pair, t, ends[0], ends[1]); // otherwise a triangle has no area
}

void OverlapPatches::add_segment(TrianglePair pair, const std::array<TrianglePoints, 2>& t, const EdgeCrossing& from,
                                 const EdgeCrossing& to)
{
    const std::uint32_t in_a = patch(0, pair.a, &t[0]), in_b = patch(1, pair.b, &t[1]);
    Patch &a = patches[0][in_a], &b = patches[1][in_b];
    add_fan(a, from.at, to.at, 1), add_fan(b, to.at, from.at, 1);
    for (const EdgeCrossing* c : {&from, &to}) {
        Patch& of = c->of_a ? a : b;
        const int next = (c->edge + 1) % 3;
        add_fan(of, of.points[c->edge], c->at, c->outward ? 1 : -1);
        of.entries[c->edge] += c->outward ? -1 : 1, ++of.crossed[c->edge];
        const PlacedSurface& surface = *surfaces_[c->of_a ? 0 : 1];
        const std::uint32_t u = of.corners[c->edge], v = of.corners[next];
        const FeatureBits edge = c->at == of.points[c->edge] ? surface.vertex(u)
                                 : c->at == of.points[next]  ? surface.vertex(v)
                                                             : surface.edge(u, v);
        const FeatureBits face = surfaces_[c->of_a ? 1 : 0]->face(c->of_a ? pair.b : pair.a);
        curve.push_back({c->at, in_a, in_b, c->of_a ? edge : face, c->of_a ? face : edge});
    }
    joins_.emplace_back(in_a, in_b);
    crossing.back() = in_a;
}

/// Finds how often the other body winds around each corner of the patches.
void OverlapPatches::wind(int side, PointLocator& locator)
{
    const PlacedSurface &own = *surfaces_[side], &other = *surfaces_[1 - side];
    std::vector<Patch>& all = patches[side];
    windings_.clear(), nodes_.clear();
    for (Patch& p : all) {
        auto& nodes = nodes_.emplace_back();
        for (int k = 0; k < 3; ++k) nodes[k] = windings_.node(p.corners[k]);
        for (int k = 0; k < 3; ++k) p.conflict |= !windings_.join(nodes[k], nodes[(k + 1) % 3], p.entries[k]);
    }
    const auto count = static_cast<std::uint32_t>(windings_.parent.size());
    constexpr int unknown = std::numeric_limits<int>::min();
    least_.assign(count, std::numeric_limits<int>::max()), most_.assign(count, unknown), base_.assign(count, unknown);
    for (std::uint32_t n = 0; n < count; ++n) {
        const auto [root, winding] = windings_.root(n);
        least_[root] = std::min(least_[root], winding), most_[root] = std::max(most_[root], winding);
    }
    for (std::uint32_t n = 0; n < count; ++n) {
        const auto [root, winding] = windings_.root(n);
        if (base_[root] != unknown) continue;
        if (most_[root] > least_[root])
            base_[root] = -least_[root]; // some corners are outside
        else if (const auto inside = other.solid() ? other.holds(own.point(windings_.vertex[n]), locator) : false)
            base_[root] = (*inside ? 1 : 0) - winding;
    }
    for (std::size_t i = 0; i < all.size(); ++i) {
        Patch& p = all[i];
        for (int k = 0; k < 3; ++k) {
            const auto [root, winding] = windings_.root(nodes_[i][k]);
            p.conflict |= base_[root] == unknown;
            p.inside[k] = (base_[root] == unknown ? 0 : base_[root]) + winding;
        }
        // The fan of an edge at the origin has no area.
        if (p.inside[2] != 0) add_fan(p, p.points[1], p.points[2], p.inside[2]);
    }
}

/// Adds the whole triangles inside, from edges inside that nothing crosses.
void OverlapPatches::fill(int side)
{
    const PlacedSurface& own = *surfaces_[side];
    const bool is_plane = own.model().kind() == Kind::half_space;
    for (std::uint32_t i = 0; i < patches[side].size(); ++i)
        for (int k = 0; k < 3; ++k) {
            const int winding = patches[side][i].inside[k];
            const bool crossed = patches[side][i].crossed[k] != 0;
            if (!crossed && winding <= 0) continue;
            const std::uint32_t beyond = own.across(patches[side][i].triangle, k);
            if (crossed) {
                const std::uint32_t next = beyond == none ? none : patch_of_[side].find(beyond);
                if (next != none) crossed_joins_[side].emplace_back(i, next);
                continue;
            }
            if (beyond == PlacedSurface::none) {
                patches[side][i].conflict |= !is_plane;
                continue;
            }
            const std::size_t before = patches[side].size();
            const std::uint32_t next = patch(side, beyond);
            if (next == before) {
                Patch& whole = patches[side][next];
                whole.inside = {winding, winding, winding};
                add_fan(whole, whole.points[1], whole.points[2], winding);
            }
            inside_joins_[side].emplace_back(i, next);
        }
}

/// Numbers the lumps, and adds their patches up.
void OverlapPatches::connect()
{
    const auto of_a = static_cast<std::uint32_t>(patches[0].size());
    roots_.resize(of_a + patches[1].size());
    std::iota(roots_.begin(), roots_.end(), 0u);
    for (const auto& [i, k] : joins_) join(roots_, i, of_a + k);
    for (const auto& [i, k] : inside_joins_[0]) join(roots_, i, k);
    for (const auto& [i, k] : inside_joins_[1]) join(roots_, of_a + i, of_a + k);
    const auto patch_at = [&](std::uint32_t i) -> Patch& { return i < of_a ? patches[0][i] : patches[1][i - of_a]; };
    for (std::uint32_t i = 0; i < roots_.size(); ++i) {
        const std::uint32_t root = root_of(roots_, i); // the first of its lump
        if (root == i) patch_at(i).lump = static_cast<std::uint32_t>(lumps.size()), lumps.emplace_back();
        patch_at(i).lump = patch_at(root).lump;
    }
    for (const CurvePoint& c : curve) lumps[patches[0][c.patch_a].lump].box.add(c.at);
    for (const int side : {0, 1})
        for (const Patch& p : patches[side]) {
            Lump& lump = lumps[p.lump];
            lump.open |= p.conflict;
            (side == 0 ? lump.area_a : lump.area_b) += p.area * p.normal;
            const Vector3d middle = lump.box.centre(); // a point on the curve, so terms are small
            lump.volume += p.area * p.normal.dot(p.points[0] - middle) / 3;
            double round = 0, reach = 0;
            for (int k = 0; k < 3; ++k) {
                round += (p.points[k] - p.points[(k + 1) % 3]).lpNorm<1>();
                reach = std::max(reach, p.points[k].lpNorm<1>());
            }
            lump.rounding += 0x1p-42 * round * reach;
        }
}

/// Joins patches across edges that are partly inside.
void OverlapPatches::find_pieces(int side)
{
    const std::vector<Patch>& all = patches[side];
    roots_.resize(all.size());
    std::iota(roots_.begin(), roots_.end(), 0u);
    for (const auto& [i, k] : inside_joins_[side]) join(roots_, i, k);
    for (const auto& [i, k] : crossed_joins_[side]) join(roots_, i, k);
    areas_.assign(all.size(), Vector3d::Zero());
    for (std::uint32_t i = 0; i < all.size(); ++i) areas_[root_of(roots_, i)] += all[i].area * all[i].normal;
    for (std::uint32_t i = 0; i < all.size(); ++i)
        if (roots_[i] == i) (side == 0 ? lumps[all[i].lump].pieces_a : lumps[all[i].lump].pieces_b) += areas_[i].norm();
}

/// Handles faces of both bodies that lie in one plane, with both bodies on one side of it: whose face borders the
/// overlap depends on the displacement. Half of their area counts.
void OverlapPatches::balance(std::span<const TrianglePair> pairs)
{
    for (const std::uint32_t number : in_planes_) {
        const TrianglePair& pair = pairs[number];
        const TrianglePoints a = surfaces_[0]->points(pair.a), b = surfaces_[1]->points(pair.b);
        const Vector3d normal = unit_normal(a[0], a[1], a[2]);
        if (!(normal.dot(unit_normal(b[0], b[1], b[2])) > 0)) continue;
        const bool of_first = moves_along(a); // a's face is inside the moved b
        const std::uint32_t found = of_first ? patch_of_[0].find(pair.a) : patch_of_[1].find(pair.b);
        if (found == none) continue;
        const std::vector<Vector3d> polygon = common_polygon(a, b, normal);
        double area = 0;
        for (std::size_t i = 2; i < polygon.size(); ++i)
            area += 0.5 * normal.dot((polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]));
        Lump& lump = lumps[patches[of_first ? 0 : 1][found].lump];
        const Vector3d half = 0.5 * area * normal;
        lump.area_a += of_first ? Vector3d(-half) : half, lump.area_b += of_first ? half : Vector3d(-half);
    }
}

void OverlapPatches::find(const PlacedSurface& a, const PlacedSurface& b, std::span<const TrianglePair> pairs,
                          PointLocator& locator)
{
    surfaces_ = {&a, &b};
    for (const int side : {0, 1})
        patches[side].clear(), patch_of_[side].clear(), inside_joins_[side].clear(), crossed_joins_[side].clear();
    curve.clear(), lumps.clear(), crossing.clear(), in_planes_.clear(), joins_.clear();
    for (std::uint32_t i = 0; i < pairs.size(); ++i) crossing.push_back(none), cross(i, pairs[i]);
    if (curve.empty()) return;
    for (const int side : {0, 1}) wind(side, locator), fill(side);
    connect();
    for (const int side : {0, 1}) find_pieces(side);
    balance(pairs);
}

} // namespace oncollide
