#include <oncollide/narrowphase/shapes/expanding_polytope.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/shapes/newton_meeting.hpp>
#include <oncollide/narrowphase/shapes/simplex.hpp>
#include <oncollide/narrowphase/shapes/triangle_axes.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// Roundings: the error of a plane that its face certainly determines.
constexpr double well_shaped = 32;
constexpr double endless = std::numeric_limits<double>::infinity();

/// A closed surface of triangles around 0, whose corners are points of the difference. A face that sees a new corner is
/// exchanged for faces between the border of all such faces and the corner.
class ExpandingPolytope {
public:
    ExpandingPolytope(const ConvexDifference& cores, double rounding) : cores_(cores), rounding_(rounding) {}
    /// @param first  the direction of the first corner; null: a likely one
    LeastTranslation find(double cutoff, const Vector3d* first);
    /// How close the bounds of curved cores get, metres.
    double close(double upper) const
    {
        const double smaller = std::min(cores_.a().extent, cores_.b().extent);
        return std::max({4 * rounding_, close_in_depth * std::abs(upper), close_in_size * smaller});
    }

private:
    static constexpr int most_corners = 112, most_faces = 2 * most_corners;
    /// Shares of the depth and of the smaller size.
    static constexpr double close_in_depth = 0x1p-8, close_in_size = 0x1p-34;

    const ConvexDifference::Point& put(const ConvexDifference::Point& p)
    {
        far_[corners_] = p.w.norm();
        return corner_[corners_] = p;
    }
    const ConvexDifference::Point& look(const Vector3d& d) { return put(cores_.support(d)); }
    bool start(Vector3d d);
    double likely_height(Vector3d& toward) const;
    void surround(const Vector3d& n);
    void add_face(int u, int v, int w);
    bool replace_visible(int corner, int face);
    int nearest_face() const
    {
        return static_cast<int>(std::min_element(d_.begin(), d_.begin() + faces_) - d_.begin());
    }
    Vector3d normal(int f) const { return {x_[f], y_[f], z_[f]}; }
    bool see(int corner);
    void set_points(LeastTranslation& found, int face) const;
    Simplex4 nearest_of(std::span<const int> corners) const;
    double polish(Vector3d& n, ConvexDifference::Point& p) const;

    const ConvexDifference& cores_;
    const double rounding_;
    int corners_ = 0, faces_ = 0;
    std::array<ConvexDifference::Point, most_corners + 1> corner_;
    std::array<double, most_corners + 1> far_;     ///< distances of the corners from 0
    std::array<double, most_faces> x_, y_, z_, d_; ///< unit normals; heights of the planes over 0
    std::array<double, most_faces> error_,
        slope_; ///< error bounds of heights over 0; their rise with each metre from 0
    std::array<std::array<int, 3>, most_faces> of_;
    std::array<double, most_faces> height_; ///< of a new corner over each plane
    std::array<bool, most_faces> sees_;     ///< the new corner
    struct Edge {
        int from, to;
        bool operator==(const Edge&) const = default;
    };
    std::array<Edge, 3 * most_faces> border_;
    int borders_ = 0;
};

/// Calls visit(normal) for normals of the flat and straight parts of a solid that face a direction, in its frame.
template <class Visit>
void each_likely_normal(const Convex& c, const Vector3d& toward, Visit visit)
{
    if (is_triangle(c)) {
        const Vector3d n = (c.points[1] - c.points[0]).cross(c.points[2] - c.points[0]);
        if (n.norm() > 0) visit((n.dot(toward) < 0 ? -1 : 1) * n.normalized());
        return;
    }
    if (c.core == Convex::Core::ellipsoid || c.core == Convex::Core::points) return;
    const Vector3d sign = toward.unaryExpr([](double x) { return x < 0 ? -1.0 : 1.0; });
    visit(sign.z() * Vector3d::UnitZ());
    if (c.flat_sided) return visit(sign.x() * Vector3d::UnitX()), visit(sign.y() * Vector3d::UnitY());
    const double across = std::hypot(toward.x(), toward.y());
    if (!(across > 0)) return;
    const Vector3d aside(toward.x() / across, toward.y() / across, 0);
    visit(c.core == Convex::Core::cone ? Vector3d(2 * c.high.z() * aside + c.high.x() * Vector3d::UnitZ()).normalized()
                                       : aside);
}

/// Exchanges a direction for the best normal on its side, improved by Newton's method. Returns the height of the
/// surface along it.
double ExpandingPolytope::likely_height(Vector3d& toward) const
{
    const Vector3d out = toward;
    Vector3d best = out.normalized();
    ConvexDifference::Point p = cores_.support(best);
    double height = best.dot(p.w);
    const auto compare = [&](const Vector3d& n) {
        const ConvexDifference::Point q = cores_.support(n);
        if (const double here = n.dot(q.w); here < height) height = here, best = n, p = q;
    };
    const auto& r = cores_.b_to_a().rotation;
    each_likely_normal(cores_.a(), -out, [&](const Vector3d& n) { compare(-n); });
    each_likely_normal(cores_.b(), r.transpose() * out, [&](const Vector3d& n) { compare(r * n); });
    const auto round = [](const Convex& c) { return c.core == Convex::Core::cylinder || c.core == Convex::Core::cone; };
    if (const Vector3d both = r.col(2).cross(Vector3d::UnitZ());
        round(cores_.a()) && round(cores_.b()) && both.norm() > 0x1p-10)
        compare(both.dot(out) < 0 ? -both.normalized() : both.normalized());
    Vector3d n = -best;
    height = polish(n, p);
    toward = -n;
    return height;
}

/// Adds corners around the one along n, so that the faces there are close to the surface.
void ExpandingPolytope::surround(const Vector3d& n)
{
    // Radians. The faces around a point of a smooth surface are then as close to it as close_in_depth wants; the
    // corners of a flat or ruled part are found by a smaller tilt, which leaves them in its plane.
    constexpr double wide = 0.1, narrow = 0.008;
    const double height = n.dot(corner_[0].w);
    const Vector3d aside = corner_[0].w - height * n;
    const bool flat = aside.norm() > 0.125 * height;
    const Vector3d u = flat ? Vector3d(aside.normalized()) : n.unitOrthogonal(), v = n.cross(u);
    const auto add = [&](const Vector3d& along, double tilt) {
        const Vector3d& p = look((n + tilt * along).normalized()).w;
        int most = -1;
        double above = 0x1p-4 * close_in_depth * std::abs(height); // corners near each other make slivers
        for (int f = 0; f < faces_; ++f)
            if (const double here = normal(f).dot(p) - d_[f] - error_[f] - slope_[f] * far_[corners_]; here > above)
                above = here, most = f;
        if (most >= 0 && replace_visible(corners_, most)) ++corners_;
    };
    add(-u, flat ? narrow : wide);
    if (flat)
        add(v, narrow), add(-v, narrow);
    else
        add(u, wide);
    add(v, wide), add(-v, wide);
}

/// A tetrahedron; false: the difference is flat within rounding, with the normal in x_, y_, z_.
bool ExpandingPolytope::start(Vector3d d)
{
    look(d), ++corners_;
    look(-d), ++corners_;
    const auto look_both = [&](const Vector3d& along) { // returns how far the better of two points is aside
        const double from = along.dot(corner_[0].w);
        const double one = along.dot(look(along).w) - from;
        const ConvexDifference::Point first = corner_[corners_];
        const double other = from - along.dot(look(-along).w);
        if (one >= other) put(first);
        return std::max(one, other) / along.norm();
    };
    const double thin = 8 * rounding_;
    Vector3d line = corner_[1].w - corner_[0].w;
    if (!(line.norm() > thin)) line = d;
    const Vector3d aside = line.unitOrthogonal();
    if (!(look_both(aside) > thin)) look_both(line.normalized().cross(aside));
    ++corners_;
    const Vector3d across = (corner_[1].w - corner_[0].w).cross(corner_[2].w - corner_[0].w);
    const double length = across.norm();
    x_[0] = 1, y_[0] = z_[0] = 0;
    if (!(length > 0)) return false;
    x_[0] = across.x() / length, y_[0] = across.y() / length, z_[0] = across.z() / length;
    if (!(look_both(across / length) > thin)) return false;
    ++corners_;
    if (across.dot(corner_[3].w - corner_[0].w) > 0) std::swap(corner_[1], corner_[2]), std::swap(far_[1], far_[2]);
    add_face(0, 1, 2), add_face(0, 3, 1), add_face(1, 3, 2), add_face(2, 3, 0);
    return true;
}

void ExpandingPolytope::add_face(int u, int v, int w)
{
    // The plane turns around the first corner, which must not be far from 0 if another one is near.
    while (far_[u] > 8 * std::min(far_[v], far_[w])) {
        const int last = u;
        u = v, v = w, w = last;
    }
    const int f = faces_++;
    of_[f] = {u, v, w};
    const Vector3d &p = corner_[u].w, q = corner_[v].w - p, r = corner_[w].w - p, n = q.cross(r);
    const double length = n.norm(), edge = std::sqrt(std::max(q.squaredNorm(), r.squaredNorm()));
    if (!(length > 0x1p-46 * edge * edge)) { // it lies on its neighbours' edges
        x_[f] = y_[f] = z_[f] = 0, d_[f] = endless, error_[f] = slope_[f] = 0;
        return;
    }
    const double inverse = 1 / length;
    x_[f] = n.x() * inverse, y_[f] = n.y() * inverse, z_[f] = n.z() * inverse;
    d_[f] = n.dot(p) * inverse;
    slope_[f] = 6 * rounding_ * edge * inverse; // bounds the angle to the plane of the true corners,
    if (slope_[f] > 0.25) slope_[f] = 1;        // where that is small
    error_[f] = 2 * rounding_ + slope_[f] * far_[u];
}

/// Finds the border of the faces that see a corner. False: the polytope would fold over at a face in whose plane,
/// within rounding, the corner is; now this face counts as seeing the corner.
bool ExpandingPolytope::see(int corner)
{
    borders_ = 0;
    for (int f = 0; f < faces_; ++f) {
        if (!sees_[f]) continue;
        for (int k = 0; k < 3; ++k) {
            const Edge edge{of_[f][k], of_[f][(k + 1) % 3]};
            int i = 0;
            while (i < borders_ && border_[i] != Edge{edge.to, edge.from}) ++i;
            if (i < borders_)
                border_[i] = border_[--borders_];
            else
                border_[borders_++] = edge;
        }
    }
    const Vector3d& p = corner_[corner].w;
    const double far = far_[corner];
    for (int f = 0; f < faces_; ++f) {
        const double error = error_[f] + slope_[f] * far;
        if (sees_[f] || height_[f] < -error || error > well_shaped * rounding_) continue;
        for (int k = 0; k < 3; ++k) {
            const int from = of_[f][(k + 1) % 3], to = of_[f][k]; // as the face on the other side has them
            const Vector3d& u = corner_[from].w;
            if (!((corner_[to].w - u).cross(p - u).dot(normal(f)) < 0)) continue;
            if (std::find(border_.begin(), border_.begin() + borders_, Edge{from, to}) == border_.begin() + borders_)
                continue;
            sees_[f] = true;
            return false;
        }
    }
    return true;
}

/// Exchanges the faces that see a corner, and `face`. False, and nothing has changed: rounding hides where the corner
/// is, or there is no room for as many faces.
bool ExpandingPolytope::replace_visible(int corner, int face)
{
    const Vector3d& p = corner_[corner].w;
    const double far = far_[corner];
    for (int f = 0; f < faces_; ++f) {
        height_[f] = x_[f] * p.x() + y_[f] * p.y() + z_[f] * p.z() - d_[f];
        sees_[f] = f == face || height_[f] > error_[f] + slope_[f] * far; // a sliver's plane errs by more than rounding
    }
    while (!see(corner)) {}
    const int visible = static_cast<int>(std::count(sees_.begin(), sees_.begin() + faces_, true));
    if (borders_ < 3 || faces_ - visible + borders_ > most_faces) return false;
    for (int f = 0; f < faces_;) {
        if (!sees_[f]) {
            ++f;
            continue;
        }
        --faces_;
        x_[f] = x_[faces_], y_[f] = y_[faces_], z_[f] = z_[faces_], d_[f] = d_[faces_];
        error_[f] = error_[faces_], slope_[f] = slope_[faces_], of_[f] = of_[faces_], sees_[f] = sees_[faces_];
    }
    for (int i = 0; i < borders_; ++i) add_face(border_[i].from, border_[i].to, corner);
    return true;
}

Simplex4 ExpandingPolytope::nearest_of(std::span<const int> corners) const
{
    Simplex4 simplex;
    for (const int k : corners) simplex.corner[simplex.count++] = corner_[k];
    simplex.reduce();
    return simplex;
}

/// The point of the face nearest to 0, as points of the cores. May lower the bound of cores that may be apart.
void ExpandingPolytope::set_points(LeastTranslation& found, int face) const
{
    const Simplex4 simplex = nearest_of(of_[face]);
    const Vector3d w = simplex.nearest();
    found.on_a = simplex.on_a(), found.on_b = found.on_a + w, found.has_points = true;
    found.lower = std::max(found.lower, -w.norm() - rounding_);
}

/// Improves the normal n of curved cores by Newton's method; p is the point along -n. Returns the depth.
double ExpandingPolytope::polish(Vector3d& n, ConvexDifference::Point& p) const
{
    double depth = -n.dot(p.w);
    for (int step = 0; step < 6; ++step) {
        const Vector3d next = (n + newton_step(cores_, n, p.w)).normalized();
        const ConvexDifference::Point q = cores_.support(-next);
        if (!(-next.dot(q.w) < depth)) break;
        n = next, p = q, depth = -n.dot(q.w);
    }
    return depth;
}

LeastTranslation ExpandingPolytope::find(double cutoff, const Vector3d* first)
{
    LeastTranslation found{};
    found.upper = endless, found.lower = -endless;
    const auto take = [&](const Vector3d& n, double height) {
        if (height + rounding_ < found.upper) found.upper = height + rounding_, found.normal = -n;
        return found.beyond = found.upper < -cutoff;
    };
    const bool curved = !cores_.flat_sided();
    Vector3d toward = first ? *first : -cores_.middle();
    if (!(toward.norm() > 0x1p-40 * cores_.size())) toward = Vector3d::UnitX();
    bool seeded = false;
    if (curved && !first) {
        Vector3d likely = toward;
        const double height = likely_height(likely);
        if (take(likely, height)) return found;
        seeded = height > 0x1p-16 * cores_.size(); // otherwise faces from near to far corners would be slivers
        if (seeded) toward = likely;
    }
    if (!start(toward)) {
        const Vector3d n = normal(0);
        if (take(n, n.dot(cores_.support(n).w)) || take(-n, -n.dot(cores_.support(-n).w))) return found;
        // 0 may be in the plane, or above it, or beside the points in it.
        constexpr int all[] = {0, 1, 2};
        found.lower =
            std::min(-nearest_of(std::span(all, std::min(corners_, 3))).nearest().norm() - rounding_, found.upper);
        found.normal_error = std::numbers::pi;
        return found;
    }
    if (seeded) surround(toward);
    int face;
    bool ends; ///< the face has the best normal
    for (;;) {
        face = nearest_face();
        const Vector3d n = normal(face);
        const ConvexDifference::Point& p = look(n);
        const double height = n.dot(p.w);
        if (take(n, height)) return found;
        const auto known = [&](int k) { return corner_[k].w == p.w; };
        const bool converged =
            curved ? found.upper - d_[face] <= close(found.upper) : height - d_[face] <= 4 * rounding_;
        ends = converged && (!curved || height + rounding_ <= found.upper);
        if (ends) found.normal = -n, found.upper = height + rounding_; // the points lie along this normal
        found.off = std::max(height - d_[face], 0.0);
        if (converged || std::ranges::any_of(of_[face], known) || corners_ == most_corners) break;
        if (!replace_visible(corners_++, face)) break;
    }
    double least = endless;
    for (int f = 0; f < faces_; ++f) least = std::min(least, d_[f] - error_[f]);
    if (least > 0 && found.upper > 0) found.lower = least; // else 0 is outside, where the planes bound nothing
    set_points(found, face);
    const auto offer = [&](const ConvexDifference::Point& p) { found.offer(p.a, p.a + p.w, 0); };
    if (!ends) { // another face has the best normal
        double most = -1;
        for (int f = 0; f < faces_; ++f)
            if (const double cosine = -found.normal.dot(normal(f)); cosine > most) most = cosine, face = f;
        set_points(found, face), found.off = std::max(found.upper - d_[face], 0.0);
        offer(cores_.support(-found.normal));
    }
    if (curved) {
        Vector3d n = found.normal;
        ConvexDifference::Point p = cores_.support(-n);
        if (const double depth = polish(n, p); depth + rounding_ < found.upper) {
            found.upper = depth + rounding_, found.normal = n;
            offer(p);
        }
    }
    found.lower = std::min(found.lower, found.upper);
    found.normal_error =
        found.lower < -hidden_gap * rounding_ ? std::numbers::pi // they may be apart, in any direction
        : !curved
            ? std::min(std::numbers::pi, error_[face] / cores_.size() * 4 + 8 * cores_.slack())
            : std::min(std::numbers::pi, std::sqrt(2 * std::max(found.upper - found.lower, 0.0) / cores_.size()) * 2);
    return found;
}

} // namespace

LeastTranslation translation_by_polytope(const ConvexDifference& cores, double rounding, double cutoff)
{
    ExpandingPolytope polytope(cores, rounding);
    LeastTranslation found = polytope.find(cutoff, nullptr);
    const auto is_loose = [&] { return found.upper - found.lower > 2 * polytope.close(found.upper) + 16 * rounding; };
    // Rounding may fold a polytope; from other corners it hardly does at the same place.
    const Vector3d n = found.normal, aside = n.unitOrthogonal();
    for (const Vector3d& first : {n, Vector3d(-n), aside, Vector3d(n.cross(aside))}) {
        if (found.beyond || !is_loose()) break;
        const LeastTranslation again = ExpandingPolytope(cores, rounding).find(cutoff, &first);
        if (again.beyond) return again;
        const double lower = std::max(found.lower, again.lower);
        if (again.upper < found.upper) found = again;
        found.lower = std::min(lower, found.upper);
    }
    return found;
}

} // namespace oncollide
