#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

#include <oncollide/scenes/files/mesh/polygon_list.hpp>

namespace oncollide {

namespace {

/// Twice the area vector, by Newell's sum: for a planar polygon its normal, also if it is not convex.
Eigen::Vector3d area_vector(std::span<const Eigen::Vector3d> vertices, std::span<const std::uint32_t> polygon)
{
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const Eigen::Vector3d& origin = vertices[polygon[0]];
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
        sum += (vertices[polygon[i]] - origin).cross(vertices[polygon[i + 1]] - origin);
    return sum;
}

/// Points in the cells of a square grid, about one per cell.
class PointGrid {
public:
    explicit PointGrid(std::span<const Eigen::Vector2d> points) : points_(points)
    {
        for (const Eigen::Vector2d& p : points) bounds_.extend(p);
        side_ = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(points.size()))));
        cells_.resize(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
        for (std::uint32_t i = 0; i < points.size(); ++i) cell_of(points[i]).push_back(i);
    }

    void remove(std::uint32_t point) { std::erase(cell_of(points_[point]), point); }

    /// Number of cells that `box` meets.
    int count(const Eigen::AlignedBox2d& box) const
    {
        return (place(box.max(), 0) - place(box.min(), 0) + 1) * (place(box.max(), 1) - place(box.min(), 1) + 1);
    }
    /// Returns a point of these cells that satisfies `wanted(point)`, if there is one.
    template <class Wanted>
    std::optional<std::uint32_t> find(const Eigen::AlignedBox2d& box, Wanted wanted) const
    {
        for (int y = place(box.min(), 1); y <= place(box.max(), 1); ++y)
            for (int x = place(box.min(), 0); x <= place(box.max(), 0); ++x)
                for (const std::uint32_t p : cells_[cell(x, y)])
                    if (wanted(p)) return p;
        return {};
    }

private:
    /// Monotonic in the coordinate, so that a point in a box is in one of the box's cells.
    int place(const Eigen::Vector2d& p, int axis) const
    {
        const double extent = bounds_.max()[axis] - bounds_.min()[axis];
        const double share = extent > 0 ? (p[axis] - bounds_.min()[axis]) / extent : 0;
        return std::clamp(static_cast<int>(share * side_), 0, side_ - 1);
    }
    std::size_t cell(int x, int y) const { return static_cast<std::size_t>(y * side_ + x); }
    std::vector<std::uint32_t>& cell_of(const Eigen::Vector2d& p) { return cells_[cell(place(p, 0), place(p, 1))]; }

    std::span<const Eigen::Vector2d> points_;
    Eigen::AlignedBox2d bounds_;
    int side_;
    std::vector<std::vector<std::uint32_t>> cells_;
};

/// A polygon projected along its normal's largest axis, oriented counter-clockwise.
class FlatPolygon {
public:
    FlatPolygon(std::span<const Eigen::Vector3d> vertices, std::span<const std::uint32_t> polygon,
                const Eigen::Vector3d& normal)
    {
        int drop = 0;
        normal.cwiseAbs().maxCoeff(&drop);
        int i = (drop + 1) % 3, j = (drop + 2) % 3;
        if (normal[drop] < 0) std::swap(i, j);
        points_.reserve(polygon.size());
        for (const std::uint32_t v : polygon) points_.push_back({vertices[v][i], vertices[v][j]});
    }

    std::uint32_t size() const { return static_cast<std::uint32_t>(points_.size()); }
    std::span<const Eigen::Vector2d> points() const { return points_; }
    const Eigen::Vector2d& operator[](std::uint32_t i) const { return points_[i]; }
    double turn(std::uint32_t a, std::uint32_t b, std::uint32_t c) const
    {
        const Eigen::Vector2d u = points_[b] - points_[a], v = points_[c] - points_[a];
        return u.x() * v.y() - u.y() * v.x();
    }

    /// True if no corner turns right and the polygon winds around once.
    bool convex() const
    {
        int changes = 0; // sign changes of the direction's x: two for one winding
        double last = 0;
        for (std::uint32_t i = 0; i < size(); ++i) {
            const std::uint32_t before = i == 0 ? size() - 1 : i - 1, after = i + 1 == size() ? 0 : i + 1;
            if (turn(before, i, after) < 0) return false;
            const double dx = points_[after].x() - points_[i].x();
            if (dx == 0) continue;
            changes += last != 0 && (dx > 0) != (last > 0);
            last = dx;
        }
        return changes <= 2;
    }

private:
    std::vector<Eigen::Vector2d> points_;
};

/// Ear clipping; each search continues after the last ear in the order of the corners. A grid finds corners inside an
/// ear, and the corner that blocked an ear is remembered: a spiral of 4,096 corners takes little more time than one
/// traversal of its corners.
class EarCutter {
public:
    explicit EarCutter(const FlatPolygon& polygon)
        : flat_(polygon), grid_(polygon.points()), before_(polygon.size()), after_(polygon.size()),
          in_the_way_(polygon.size(), none), cut_(polygon.size(), false), left_(polygon.size())
    {
        for (std::uint32_t i = 0; i < left_; ++i) {
            before_[i] = i == 0 ? left_ - 1 : i - 1;
            after_[i] = i + 1 == left_ ? 0 : i + 1;
        }
    }

    /// Calls add(a, b, c) for each triangle. If no ear is left, the polygon intersects itself, and the next corner is
    /// cut off. After several such failures all corners are cut off without a search, which would take cubic time.
    template <class Add>
    void cut(Add add)
    {
        std::uint32_t at = 0, tried = 0, forced = 0;
        while (left_ > 3) {
            const bool no_ear = tried == left_;
            forced += no_ear;
            if (no_ear || forced > most_forced || is_ear(at)) {
                add(before_[at], at, after_[at]);
                remove(at);
                tried = 0;
            } else {
                ++tried;
            }
            at = after_[at];
        }
        std::uint32_t first = 0;
        while (cut_[first]) ++first;
        add(first, after_[first], before_[first]);
    }

private:
    static constexpr std::uint32_t most_forced = 16, none = 0xffffffffu;

    void remove(std::uint32_t at)
    {
        const std::uint32_t a = before_[at], c = after_[at];
        after_[a] = c, before_[c] = a; // the links of `at` stay valid for iterations that have reached it
        in_the_way_[a] = in_the_way_[c] = none;
        cut_[at] = true;
        grid_.remove(at);
        --left_;
    }

    bool is_ear(std::uint32_t b)
    {
        const std::uint32_t a = before_[b], c = after_[b];
        if (!(flat_.turn(a, b, c) > 0)) return false;
        if (in_the_way_[b] != none && !cut_[in_the_way_[b]]) return false;
        const auto holds = [&](std::uint32_t p) {
            if (flat_[p] == flat_[a] || flat_[p] == flat_[b] || flat_[p] == flat_[c]) return false;
            return flat_.turn(a, b, p) >= 0 && flat_.turn(b, c, p) >= 0 && flat_.turn(c, a, p) >= 0;
        };
        Eigen::AlignedBox2d box(flat_[a]);
        box.extend(flat_[b]).extend(flat_[c]);
        std::optional<std::uint32_t> found;
        if (grid_.count(box) < static_cast<int>(left_))
            found = grid_.find(box, holds);
        else
            for (std::uint32_t p = after_[c]; p != a && !found; p = after_[p])
                if (holds(p)) found = p;
        in_the_way_[b] = found.value_or(none);
        return !found;
    }

    const FlatPolygon& flat_;
    PointGrid grid_; ///< corners not yet cut off
    std::vector<std::uint32_t> before_, after_;
    std::vector<std::uint32_t> in_the_way_; ///< for each corner: another corner that was inside its ear
    std::vector<bool> cut_;
    std::uint32_t left_;
};

} // namespace

bool triangulate(std::span<const Eigen::Vector3d> vertices, std::span<const std::uint32_t> polygon,
                 std::vector<Triangle>& triangles)
{
    const Eigen::Vector3d normal = polygon.size() > 3 ? area_vector(vertices, polygon) : Eigen::Vector3d::Zero();
    if (!normal.isZero(0) && normal.allFinite()) {
        const FlatPolygon flat(vertices, polygon, normal);
        if (!flat.convex()) {
            if (polygon.size() > most_concave_corners) return false;
            EarCutter(flat).cut([&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
                triangles.push_back({polygon[a], polygon[b], polygon[c]});
            });
            return true;
        }
    }
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i) triangles.push_back({polygon[0], polygon[i], polygon[i + 1]});
    return true;
}

} // namespace oncollide
