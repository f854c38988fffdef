#include <oncollide/narrowphase/shapes/expanding_polytope.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/shapes/newton_meeting.hpp>
#include <oncollide/narrowphase/shapes/simplex.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

constexpr double endless = std::numeric_limits<double>::infinity();

/// A closed surface of triangles around 0, whose corners are points of the difference. A face that sees a new corner is
/// exchanged for faces between the border of all such faces and the corner.
class ExpandingPolytope {
public:
    ExpandingPolytope(const ConvexDifference& cores, double rounding) : cores_(cores), rounding_(rounding) {}
    LeastTranslation find(double cutoff);

private:
    static constexpr int most_corners = 112, most_faces = 2 * most_corners;
    /// Shares of the depth and of the smaller size: how close the bounds of curved cores get.
    static constexpr double close_in_depth = 0x1p-17, close_in_size = 0x1p-34;

    const ConvexDifference::Point& look(const Vector3d& d)
    {
        corner_[corners_] = cores_.support(d);
        return corner_[corners_];
    }
    bool start();
    void add_face(int u, int v, int w);
    bool replace_visible(int corner, int face);
    int nearest_face() const
    {
        return static_cast<int>(std::min_element(d_.begin(), d_.begin() + faces_) - d_.begin());
    }
    Vector3d normal(int f) const { return {x_[f], y_[f], z_[f]}; }
    void set_points(LeastTranslation& found, int face) const;
    void polish(LeastTranslation& found) const;

    const ConvexDifference& cores_;
    const double rounding_;
    int corners_ = 0, faces_ = 0;
    std::array<ConvexDifference::Point, most_corners + 1> corner_;
    std::array<double, most_faces> x_, y_, z_, d_; ///< unit normals; heights of the planes over 0
    std::array<double, most_faces> error_;         ///< error bounds of the heights
    std::array<std::array<int, 3>, most_faces> of_;
    std::array<bool, most_faces> sees_;
    std::array<std::pair<int, int>, 3 * most_faces> border_;
};

/// A tetrahedron; false: the difference is flat within rounding, with the normal in x_, y_, z_.
bool ExpandingPolytope::start()
{
    Vector3d d = -cores_.middle();
    if (!(d.norm() > 0x1p-40 * cores_.size())) d = Vector3d::UnitX();
    look(d), ++corners_;
    look(-d), ++corners_;
    const auto look_both = [&](const Vector3d& along) { // returns how far the better of two points is aside
        const double from = along.dot(corner_[0].w);
        const double one = along.dot(look(along).w) - from;
        const ConvexDifference::Point first = corner_[corners_];
        const double other = from - along.dot(look(-along).w);
        if (one >= other) corner_[corners_] = first;
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
    if (across.dot(corner_[3].w - corner_[0].w) > 0) std::swap(corner_[1], corner_[2]);
    add_face(0, 1, 2), add_face(0, 3, 1), add_face(1, 3, 2), add_face(2, 3, 0);
    return true;
}

void ExpandingPolytope::add_face(int u, int v, int w)
{
    const Vector3d &p = corner_[u].w, q = corner_[v].w - p, r = corner_[w].w - p, n = q.cross(r);
    const double length = n.norm(), edge = std::sqrt(std::max(q.squaredNorm(), r.squaredNorm()));
    const int f = faces_++;
    of_[f] = {u, v, w};
    if (!(length > 0x1p-46 * edge * edge)) { // it lies on its neighbours' edges
        x_[f] = y_[f] = z_[f] = 0, d_[f] = endless, error_[f] = 0;
        return;
    }
    x_[f] = n.x() / length, y_[f] = n.y() / length, z_[f] = n.z() / length;
    d_[f] = n.dot(p) / length;
    error_[f] = rounding_ * (2 + 4 * (p.norm() + edge) * edge / length);
}

/// Exchanges the faces that see a corner, and `face`. False, and nothing has changed: there is no room for as many
/// faces.
bool ExpandingPolytope::replace_visible(int corner, int face)
{
    const Vector3d& p = corner_[corner].w;
    int border = 0, visible = 0;
    for (int f = 0; f < faces_; ++f) {
        // A sliver's plane errs by more than a rounding.
        sees_[f] = f == face || x_[f] * p.x() + y_[f] * p.y() + z_[f] * p.z() - d_[f] > error_[f];
        if (!sees_[f]) continue;
        ++visible;
        for (int k = 0; k < 3; ++k) {
            const std::pair edge(of_[f][k], of_[f][(k + 1) % 3]);
            int i = 0;
            while (i < border && border_[i] != std::pair(edge.second, edge.first)) ++i;
            if (i < border)
                border_[i] = border_[--border];
            else
                border_[border++] = edge;
        }
    }
    if (faces_ - visible + border > most_faces) return false;
    for (int f = 0; f < faces_;) {
        if (!sees_[f]) {
            ++f;
            continue;
        }
        --faces_;
        x_[f] = x_[faces_], y_[f] = y_[faces_], z_[f] = z_[faces_], d_[f] = d_[faces_], error_[f] = error_[faces_];
        of_[f] = of_[faces_], sees_[f] = sees_[faces_];
    }
    for (int i = 0; i < border; ++i) add_face(border_[i].first, border_[i].second, corner);
    return true;
}

/// The point of the face nearest to 0, as points of the cores. May lower the bound of cores that may be apart.
void ExpandingPolytope::set_points(LeastTranslation& found, int face) const
{
    Simplex4 simplex;
    for (const int k : of_[face]) simplex.corner[simplex.count++] = corner_[k];
    simplex.reduce();
    const Vector3d w = simplex.nearest();
    found.on_a = simplex.on_a(), found.on_b = found.on_a + w, found.has_points = true;
    found.lower = std::max(found.lower, -w.norm() - rounding_);
}

/// Improves the normal of curved cores by Newton's method.
void ExpandingPolytope::polish(LeastTranslation& found) const
{
    Vector3d n = found.normal;
    ConvexDifference::Point p = cores_.support(-n);
    double depth = -n.dot(p.w);
    for (int step = 0; step < 6; ++step) {
        const Vector3d next = (n + newton_step(cores_, n, p.w)).normalized();
        const ConvexDifference::Point q = cores_.support(-next);
        if (!(-next.dot(q.w) < depth)) break;
        n = next, p = q, depth = -n.dot(q.w);
    }
    if (!(depth + rounding_ < found.upper)) return;
    found.upper = depth + rounding_, found.normal = n;
    found.on_a = p.a, found.on_b = p.a + p.w, found.off = 0; // points of the surfaces
}

LeastTranslation ExpandingPolytope::find(double cutoff)
{
    LeastTranslation found{};
    found.upper = endless, found.lower = -endless;
    const auto take = [&](const Vector3d& n, double height) {
        if (height + rounding_ < found.upper) found.upper = height + rounding_, found.normal = -n;
        return found.beyond = found.upper < -cutoff;
    };
    if (!start()) {
        const Vector3d n = normal(0);
        if (take(n, n.dot(cores_.support(n).w)) || take(-n, -n.dot(cores_.support(-n).w))) return found;
        found.lower = -rounding_, found.normal_error = std::numbers::pi;
        return found;
    }
    int face;
    bool converged;
    for (;;) {
        face = nearest_face();
        const Vector3d n = normal(face);
        const ConvexDifference::Point& p = look(n);
        const double height = n.dot(p.w);
        if (take(n, height)) return found;
        const double enough = cores_.flat_sided()
                                  ? 4 * rounding_
                                  : std::max({4 * rounding_, close_in_depth * std::abs(found.upper),
                                              close_in_size * std::min(cores_.a().extent, cores_.b().extent)});
        const auto known = [&](int k) { return corner_[k].w == p.w; };
        converged = height - d_[face] <= enough;
        if (converged) found.normal = -n, found.upper = height + rounding_; // the points lie along this normal
        found.off = std::max(height - d_[face], 0.0);
        if (converged || std::ranges::any_of(of_[face], known) || corners_ == most_corners) break;
        if (!replace_visible(corners_++, face)) break;
    }
    double least = endless;
    for (int f = 0; f < faces_; ++f) least = std::min(least, d_[f] - error_[f]);
    if (least > 0) found.lower = least;
    set_points(found, face);
    if (!converged) { // another face has the best normal
        const ConvexDifference::Point p = cores_.support(-found.normal);
        found.on_a = p.a, found.on_b = p.a + p.w, found.off = 0;
    }
    if (!cores_.flat_sided()) polish(found);
    found.lower = std::min(found.lower, found.upper);
    found.normal_error =
        cores_.flat_sided()
            ? std::min(std::numbers::pi, error_[face] / cores_.size() * 4 + 8 * cores_.slack())
            : std::min(std::numbers::pi, std::sqrt(2 * std::max(found.upper - found.lower, 0.0) / cores_.size()) * 2);
    return found;
}

} // namespace

LeastTranslation translation_by_polytope(const ConvexDifference& cores, double rounding, double cutoff)
{
    return ExpandingPolytope(cores, rounding).find(cutoff);
}

} // namespace oncollide
