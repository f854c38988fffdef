#include <oncollide/narrowphase/pairs/manifolds/overlap_patches.hpp>

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/moved_apart.hpp>
#include <oncollide/narrowphase/pairs/manifolds/common_polygon.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

/// Adds `times` the triangle (origin, u, v), where the origin is the patch's first corner.
void add_fan(Patch& patch, const Vector3d& u, const Vector3d& v, double times)
{
    const Vector3d& origin = patch.points[0];
    const double area = 0.5 * times * patch.normal.dot((u - origin).cross(v - origin));
    patch.area += area, patch.moment += area / 3 * (origin + u + v);
}

/// The crossing of an edge of one triangle with the other triangle.
struct EdgeCrossing {
    bool of_a;
    int edge;
    bool outward; ///< the edge leaves the other body
    Vector3d at;
};

/// Disjoint sets of vertices with the difference of their windings.
struct Windings {
    std::unordered_map<std::uint32_t, std::uint32_t> number;
    std::vector<std::uint32_t> parent, vertex;
    std::vector<int> above; ///< winding less the parent's

    std::uint32_t node(std::uint32_t v)
    {
        const auto [at, added] = number.emplace(v, parent.size());
        if (added) parent.push_back(at->second), above.push_back(0), vertex.push_back(v);
        return at->second;
    }
    std::pair<std::uint32_t, int> root(std::uint32_t n)
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
    bool join(std::uint32_t u, std::uint32_t v, int more_at_v)
    {
        const auto [root_u, of_u] = root(u);
        const auto [root_v, of_v] = root(v);
        if (root_u == root_v) return of_v == of_u + more_at_v;
        const auto [low, high] = std::minmax(root_u, root_v);
        parent[high] = low;
        above[high] = high == root_v ? of_u + more_at_v - of_v : of_v - more_at_v - of_u;
        return true;
    }
};

std::uint32_t root_of(std::vector<std::uint32_t>& roots, std::uint32_t i)
{
    while (roots[i] != i) i = roots[i] = roots[roots[i]];
    return i;
}

} // namespace

std::uint32_t OverlapPatches::patch(int side, std::uint32_t triangle)
{
    const auto [at, added] = sides_[side].patch_of.emplace(triangle, static_cast<std::uint32_t>(patches[side].size()));
    if (added) {
        Patch& p = patches[side].emplace_back();
        p.triangle = triangle, p.corners = sides_[side].surface->corners(triangle);
        for (int k = 0; k < 3; ++k) p.points[k] = sides_[side].surface->point(p.corners[k]);
        p.normal = unit_normal(p.points[0], p.points[1], p.points[2]);
    }
    return at->second;
}

/// Adds the common segment of two triangles, if they cross.
void OverlapPatches::cross(TrianglePair pair)
{
    const std::array<TrianglePoints, 2> t{sides_[0].surface->points(pair.a), sides_[1].surface->points(pair.b)};
    int side[2][3]; // of the corners of each, as seen from the other's plane
    for (int k = 0; k < 3; ++k)
        side[0][k] = moved_side(t[1], t[0][k], true), side[1][k] = moved_side(t[0], t[1][k], false);
    for (const auto& s : side)
        if (s[0] == s[1] && s[0] == s[2]) return;
    int turn[3][3];
    bool known[3][3] = {};
    const auto turned = [&](int i, int k) {
        if (!known[i][k])
            turn[i][k] = moved_turn(t[0][i], t[0][(i + 1) % 3], t[1][k], t[1][(k + 1) % 3]), known[i][k] = true;
        return turn[i][k];
    };
    std::array<EdgeCrossing, 6> found;
    int count = 0;
    for (const int body : {0, 1})
        for (int i = 0; i < 3; ++i) {
            const int from = side[body][i], to = side[body][(i + 1) % 3];
            if (from == to || from == 0 || to == 0) continue;
            const int first = body == 0 ? turned(i, 0) : turned(0, i), second = body == 0 ? turned(i, 1) : turned(1, i);
            if (first != second || first == 0) continue;
            if ((body == 0 ? turned(i, 2) : turned(2, i)) != first) continue;
            const Vector3d &p = t[body][i], &q = t[body][(i + 1) % 3];
            const TrianglePoints& face = t[1 - body];
            const int exact_p = orient3d(face[0], face[1], face[2], p),
                      exact_q = orient3d(face[0], face[1], face[2], q);
            const double at = exact_p == 0         ? 0
                              : exact_q == 0       ? 1
                              : exact_p == exact_q ? 0.5
                                                   : crossing_parameter(face[0], face[1], face[2], p, q);
            if (count == 6) return;
            found[count++] = {body == 0, i, to > 0, p + at * (q - p)};
        }
    if (count != 2) return;                                                        // a triangle without area
    const auto starts = [](const EdgeCrossing& c) { return c.outward == c.of_a; }; // the segment, as seen from a
    if (starts(found[0]) == starts(found[1])) return;
    if (!starts(found[0])) std::swap(found[0], found[1]);
    const std::uint32_t in_a = patch(0, pair.a), in_b = patch(1, pair.b);
    Patch &a = patches[0][in_a], &b = patches[1][in_b];
    add_fan(a, found[0].at, found[1].at, 1), add_fan(b, found[1].at, found[0].at, 1);
    a.crossing = b.crossing = true;
    for (int e = 0; e < 2; ++e) {
        const EdgeCrossing& c = found[e];
        Patch& of = c.of_a ? a : b;
        add_fan(of, of.points[c.edge], c.at, c.outward ? 1 : -1);
        of.entries[c.edge] += c.outward ? -1 : 1, ++of.crossed[c.edge];
        const PlacedSurface& surface = *sides_[c.of_a ? 0 : 1].surface;
        const std::uint32_t u = of.corners[c.edge], v = of.corners[(c.edge + 1) % 3];
        const FeatureBits edge = c.at == surface.point(u)   ? surface.vertex(u)
                                 : c.at == surface.point(v) ? surface.vertex(v)
                                                            : surface.edge(u, v);
        const FeatureBits face = sides_[c.of_a ? 1 : 0].surface->face(c.of_a ? pair.b : pair.a);
        curve.push_back({c.at, in_a, in_b, c.of_a ? edge : face, c.of_a ? face : edge});
    }
    joins_.emplace_back(in_a, in_b);
}

/// Finds how often the other body winds around each corner of the patches.
void OverlapPatches::wind(int side, PointLocator& locator)
{
    const PlacedSurface &own = *sides_[side].surface, &other = *sides_[1 - side].surface;
    std::vector<Patch>& all = patches[side];
    conflict_[side].assign(all.size(), 0);
    Windings windings;
    for (std::size_t i = 0; i < all.size(); ++i)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t u = windings.node(all[i].corners[k]), v = windings.node(all[i].corners[(k + 1) % 3]);
            conflict_[side][i] |= !windings.join(u, v, all[i].entries[k]);
        }
    const std::size_t nodes = windings.parent.size();
    std::vector<int> least(nodes, std::numeric_limits<int>::max()), most(nodes, std::numeric_limits<int>::min());
    for (std::uint32_t n = 0; n < nodes; ++n) {
        const auto [root, winding] = windings.root(n);
        least[root] = std::min(least[root], winding), most[root] = std::max(most[root], winding);
    }
    std::vector<std::optional<int>> base(nodes);
    for (std::uint32_t n = 0; n < nodes; ++n) {
        const auto [root, winding] = windings.root(n);
        if (base[root]) continue;
        if (most[root] > least[root])
            base[root] = -least[root]; // some corners are outside
        else if (const auto inside = other.solid() ? other.holds(own.point(windings.vertex[n]), locator) : false)
            base[root] = (*inside ? 1 : 0) - winding;
    }
    for (Patch& p : all)
        for (int k = 0; k < 3; ++k) {
            const auto [root, winding] = windings.root(windings.number[p.corners[k]]);
            p.inside[k] = base[root].value_or(0) + winding;
        }
    for (std::size_t i = 0; i < all.size(); ++i)
        for (int k = 0; k < 3; ++k) {
            conflict_[side][i] |= !base[windings.root(windings.number[all[i].corners[k]]).first].has_value();
            add_fan(all[i], all[i].points[k], all[i].points[(k + 1) % 3], all[i].inside[(k + 1) % 3]);
        }
}

/// Adds the whole triangles inside, from edges inside that nothing crosses.
void OverlapPatches::fill(int side)
{
    const PlacedSurface& own = *sides_[side].surface;
    auto& joins = side == 0 ? joins_a_ : joins_b_;
    for (std::uint32_t i = 0; i < patches[side].size(); ++i)
        for (int k = 0; k < 3; ++k) {
            const Patch from = patches[side][i];
            const int winding = from.inside[k];
            if (from.crossed[k] || winding <= 0) continue;
            const std::uint32_t beyond = own.across(from.triangle, k);
            if (beyond == PlacedSurface::none) {
                conflict_[side][i] |= own.model().kind() != Kind::half_space;
                continue;
            }
            const std::size_t before = patches[side].size();
            const std::uint32_t next = patch(side, beyond);
            if (next == before) {
                Patch& whole = patches[side][next];
                conflict_[side].push_back(0);
                whole.inside = {winding, winding, winding};
                add_fan(whole, whole.points[1], whole.points[2], winding);
            }
            joins.emplace_back(i, next);
        }
}

/// Numbers the lumps, and adds their patches up.
void OverlapPatches::connect()
{
    const auto of_a = static_cast<std::uint32_t>(patches[0].size());
    roots_.resize(of_a + patches[1].size());
    std::iota(roots_.begin(), roots_.end(), 0u);
    const auto join = [&](std::uint32_t i, std::uint32_t k) {
        const std::uint32_t u = root_of(roots_, i), v = root_of(roots_, k);
        roots_[std::max(u, v)] = std::min(u, v);
    };
    for (const auto& [i, k] : joins_) join(i, of_a + k);
    for (const auto& [i, k] : joins_a_) join(i, k);
    for (const auto& [i, k] : joins_b_) join(of_a + i, of_a + k);
    std::vector<std::uint32_t> number(roots_.size());
    for (std::uint32_t i = 0; i < roots_.size(); ++i) {
        const std::uint32_t root = root_of(roots_, i);
        if (root == i) number[i] = static_cast<std::uint32_t>(lumps.size()), lumps.emplace_back();
        (i < of_a ? patches[0][i] : patches[1][i - of_a]).lump = number[root];
    }
    for (const CurvePoint& c : curve) lumps[patches[0][c.patch_a].lump].box.add(c.at);
    for (const int side : {0, 1})
        for (std::size_t i = 0; i < patches[side].size(); ++i) {
            const Patch& p = patches[side][i];
            Lump& lump = lumps[p.lump];
            lump.open |= conflict_[side][i] != 0;
            (side == 0 ? lump.area_a : lump.area_b) += p.area * p.normal;
            const Vector3d middle = lump.box.centre(); // on the curve, so terms are small
            lump.volume += p.area * p.normal.dot(p.points[0] - middle) / 3;
            double round = 0, reach = 0;
            for (int k = 0; k < 3; ++k) {
                round += (p.points[k] - p.points[(k + 1) % 3]).norm();
                reach = std::max(reach, p.points[k].norm());
            }
            lump.rounding += 0x1p-42 * round * reach;
        }
}

/// Joins patches across edges that are partly inside.
void OverlapPatches::find_pieces(int side)
{
    std::vector<Patch>& all = patches[side];
    roots_.resize(all.size());
    std::iota(roots_.begin(), roots_.end(), 0u);
    for (std::uint32_t i = 0; i < all.size(); ++i)
        for (int k = 0; k < 3; ++k) {
            if (!all[i].crossed[k] && all[i].inside[k] <= 0) continue;
            const auto beyond = sides_[side].patch_of.find(sides_[side].surface->across(all[i].triangle, k));
            if (beyond == sides_[side].patch_of.end()) continue;
            const std::uint32_t u = root_of(roots_, i), v = root_of(roots_, beyond->second);
            roots_[std::max(u, v)] = std::min(u, v);
        }
    std::vector<Vector3d> areas(all.size(), Vector3d::Zero());
    for (std::uint32_t i = 0; i < all.size(); ++i) {
        all[i].piece = root_of(roots_, i);
        areas[all[i].piece] += all[i].area * all[i].normal;
    }
    for (std::uint32_t i = 0; i < all.size(); ++i)
        if (all[i].piece == i)
            (side == 0 ? lumps[all[i].lump].pieces_a : lumps[all[i].lump].pieces_b) += areas[i].norm();
}

/// Faces of both that lie in one plane, on one side of both bodies: whose face borders the overlap depends on the
/// displacement. Half of it counts.
void OverlapPatches::balance(std::span<const TrianglePair> pairs)
{
    for (const TrianglePair& pair : pairs) {
        const auto of_a = sides_[0].patch_of.find(pair.a), of_b = sides_[1].patch_of.find(pair.b);
        if (of_a == sides_[0].patch_of.end() && of_b == sides_[1].patch_of.end()) continue;
        const TrianglePoints a = sides_[0].surface->points(pair.a), b = sides_[1].surface->points(pair.b);
        if (orient3d(a[0], a[1], a[2], b[0]) != 0 || !in_one_plane(a, b)) continue;
        const Vector3d normal = unit_normal(a[0], a[1], a[2]);
        if (!(normal.dot(unit_normal(b[0], b[1], b[2])) > 0)) continue;
        const std::vector<Vector3d> polygon = common_polygon(a, b, normal);
        double area = 0;
        for (std::size_t i = 2; i < polygon.size(); ++i)
            area += 0.5 * normal.dot((polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]));
        const bool of_first = moves_along(a); // a's face is inside the moved b
        const auto& found = of_first ? of_a : of_b;
        if (found == sides_[of_first ? 0 : 1].patch_of.end()) continue;
        Lump& lump = lumps[patches[of_first ? 0 : 1][found->second].lump];
        const Vector3d half = 0.5 * area * normal;
        lump.area_a += of_first ? Vector3d(-half) : half, lump.area_b += of_first ? half : Vector3d(-half);
    }
}

void OverlapPatches::find(const PlacedSurface& a, const PlacedSurface& b, std::span<const TrianglePair> pairs,
                          PointLocator& locator)
{
    sides_[0].surface = &a, sides_[1].surface = &b;
    crossing.clear();
    for (const TrianglePair& pair : pairs) {
        const std::size_t before = curve.size();
        cross(pair);
        crossing.push_back(curve.size() > before);
    }
    if (curve.empty()) return;
    for (const int side : {0, 1}) wind(side, locator), fill(side);
    connect();
    for (const int side : {0, 1}) find_pieces(side);
    balance(pairs);
}

} // namespace oncollide
