#include <algorithm>
#include <numeric>

#include <Eigen/Geometry>

#include <oncollide/scenes/files/mesh_source.hpp>

namespace oncollide {

namespace {

/// Twice the area vector, by Newell's sum: for a planar polygon its normal, whatever its shape.
Eigen::Vector3d area_vector(std::span<const Eigen::Vector3d> vertices, std::span<const std::uint32_t> polygon)
{
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const Eigen::Vector3d& origin = vertices[polygon[0]];
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
        sum += (vertices[polygon[i]] - origin).cross(vertices[polygon[i + 1]] - origin);
    return sum;
}

/// Ears are cut in the plane that drops the normal's largest axis, oriented so that the polygon turns left.
class EarCutter {
public:
    EarCutter(std::span<const Eigen::Vector3d> vertices, std::span<const std::uint32_t> polygon,
              const Eigen::Vector3d& normal)
        : polygon_(polygon), ring_(polygon.size())
    {
        int drop = 0;
        normal.cwiseAbs().maxCoeff(&drop);
        int i = (drop + 1) % 3, j = (drop + 2) % 3;
        if (normal[drop] < 0) std::swap(i, j);
        for (const std::uint32_t v : polygon) flat_.push_back({vertices[v][i], vertices[v][j]});
        std::iota(ring_.begin(), ring_.end(), 0u);
    }

    /// Every corner turns left or goes straight on, once around.
    bool convex() const
    {
        int changes = 0; // of the direction's sign along x: two for one turn
        double last = 0;
        for (std::size_t i = 0; i < ring_.size(); ++i) {
            if (turn(corner(i, -1), ring_[i], corner(i, 1)) < 0) return false;
            const double dx = flat_[corner(i, 1)].x() - flat_[ring_[i]].x();
            if (dx == 0) continue;
            changes += last != 0 && (dx > 0) != (last > 0);
            last = dx;
        }
        return changes <= 2;
    }

    /// Where no ear is left the polygon crosses itself, and any cut will do. One that does so again and again is not
    /// searched any more: that would take time by the cube of its corners.
    void cut(std::vector<Triangle>& triangles)
    {
        std::size_t at = 0, tried = 0, forced = 0;
        while (ring_.size() > 3) {
            const bool no_ear = tried == ring_.size();
            forced += no_ear;
            if (no_ear || forced > most_forced || is_ear(at)) {
                add(corner(at, -1), ring_[at], corner(at, 1), triangles);
                ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(at));
                tried = 0;
            } else {
                ++at, ++tried;
            }
            if (at >= ring_.size()) at = 0;
        }
        add(ring_[0], ring_[1], ring_[2], triangles);
    }

private:
    static constexpr std::size_t most_forced = 16;

    std::uint32_t corner(std::size_t i, int step) const
    {
        return ring_[(i + ring_.size() + static_cast<std::size_t>(step)) % ring_.size()];
    }
    double turn(std::uint32_t a, std::uint32_t b, std::uint32_t c) const
    {
        const Eigen::Vector2d u = flat_[b] - flat_[a], v = flat_[c] - flat_[a];
        return u.x() * v.y() - u.y() * v.x();
    }
    bool is_ear(std::size_t at) const
    {
        const std::uint32_t a = corner(at, -1), b = ring_[at], c = corner(at, 1);
        if (!(turn(a, b, c) > 0)) return false;
        return std::none_of(ring_.begin(), ring_.end(), [&](std::uint32_t p) {
            if (flat_[p] == flat_[a] || flat_[p] == flat_[b] || flat_[p] == flat_[c]) return false;
            return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
        });
    }
    void add(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::vector<Triangle>& triangles) const
    {
        triangles.push_back({polygon_[a], polygon_[b], polygon_[c]});
    }

    std::span<const std::uint32_t> polygon_;
    std::vector<std::uint32_t> ring_; ///< corners not yet cut off
    std::vector<Eigen::Vector2d> flat_;
};

} // namespace

bool triangulate(std::span<const Eigen::Vector3d> vertices, std::span<const std::uint32_t> polygon,
                 std::vector<Triangle>& triangles)
{
    const Eigen::Vector3d normal = polygon.size() > 3 ? area_vector(vertices, polygon) : Eigen::Vector3d::Zero();
    if (!normal.isZero(0) && normal.allFinite()) {
        EarCutter cutter(vertices, polygon, normal);
        if (!cutter.convex()) {
            if (polygon.size() > most_concave_corners) return false;
            cutter.cut(triangles);
            return true;
        }
    }
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i) triangles.push_back({polygon[0], polygon[i], polygon[i + 1]});
    return true;
}

} // namespace oncollide
