#include <oncollide/narrowphase/tight_cells.hpp>

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace oncollide {

namespace {

using Eigen::Array3d;
using Eigen::Vector3d;

constexpr std::uint32_t most_triangles = 96; // more are no disc

struct Interval {
    double low = 1e300, high = -1e300;

    void add(const Interval& other) { low = std::min(low, other.low), high = std::max(high, other.high); }
    void cut(double centre, double half) { low = std::max(low, centre - half), high = std::min(high, centre + half); }
};

Vector3d point(const Primitive& p, int k)
{
    return {p.point[k][0], p.point[k][1], p.point[k][2]};
}

Vector3d normal(const Primitive& p)
{
    return {p.point[0][3], p.point[1][3], p.point[2][3]};
}

void set(TightBlock& block, unsigned k, const TightCell& c)
{
    block.x[k] = c.x, block.y[k] = c.y, block.z[k] = c.z, block.r[k] = c.r;
    block.nx[k] = c.nx, block.ny[k] = c.ny, block.nz[k] = c.nz, block.h[k] = c.h;
}

/// The surface in one octant, in the geometry's frame relative to its root's centre.
class Octant {
public:
    Octant(const Surface& surface, const OctantCell& cell, const TriangleSpan& found, unsigned k)
        : surface_(surface), found_(found), bit_(1u << k)
    {
        for (int axis = 0; axis < 3; ++axis) {
            half_[axis] = 0.5 * double(cell.half[axis]);
            centre_[axis] = double(cell.centre[axis]) + (k >> axis & 1 ? half_[axis] : -half_[axis]);
        }
        radius_ = half_.matrix().norm();
        margin_ = cell.slack;
    }

    TightCell bound()
    {
        for (std::uint32_t i = 0; i < found_.count; ++i) triangles_ += (found_.masks[i] & bit_) != 0;
        if (triangles_ == 0 || triangles_ > most_triangles) return plain_cell;
        find_box_and_normal();
        TightCell cell = plain_cell;
        set_direction(cell);
        Vector3d centre = set_centre(cell, 0.5 * (low_ + high_).matrix());
        const Interval at_first = extent(centre);
        // Half way between the planes: what the disc has on both sides of its middle is then least.
        centre = set_centre(cell, centre + 0.5 * (at_first.low + at_first.high) * direction_);
        const double radius = radius_around(centre);
        if (radius <= radius_)
            cell.r = part(radius);
        else // the plain sphere, but with its slab
            centre = set_centre(cell, centre_.matrix());
        const Interval extent_now = extent(centre);
        cell.h = std::min(cell.r, part(std::max(-extent_now.low, extent_now.high) + margin_));
        return cell;
    }

private:
    std::uint8_t part(double length) const
    {
        return static_cast<std::uint8_t>(std::clamp(std::ceil(255 * length / radius_), 1.0, 255.0));
    }

    /// Of the boxes of the triangles, cut to the octant; and of their normals, whichever side they are on: all as if on
    /// the one side of the axis that most of them are along, so that the order of the triangles does not count.
    void find_box_and_normal()
    {
        low_.setConstant(1e300), high_.setConstant(-1e300);
        Array3d along = Array3d::Zero();
        for (std::uint32_t i = 0; i < found_.count; ++i) {
            if (!(found_.masks[i] & bit_)) continue;
            const Primitive& p = surface_.primitives[found_.ids[i]];
            const Vector3d a = point(p, 0), b = point(p, 1), c = point(p, 2);
            low_ = low_.min(a.cwiseMin(b).cwiseMin(c).array()), high_ = high_.max(a.cwiseMax(b).cwiseMax(c).array());
            along += normal(p).array().abs();
        }
        low_ = low_.max(centre_ - half_) - margin_, high_ = high_.min(centre_ + half_) + margin_;
        int axis = 0;
        along.maxCoeff(&axis);
        for (std::uint32_t i = 0; i < found_.count; ++i) {
            if (!(found_.masks[i] & bit_)) continue;
            const Vector3d n = normal(surface_.primitives[found_.ids[i]]);
            direction_ += faces_back(n, axis) ? -n : n;
        }
    }

    /// By the first of its coordinates, from `axis` on, that is not 0.
    static bool faces_back(const Vector3d& n, int axis)
    {
        for (int k = axis; k < axis + 3; ++k)
            if (n[k % 3] != 0) return n[k % 3] < 0;
        return false;
    }

    void set_direction(TightCell& cell)
    {
        const double largest = direction_.cwiseAbs().maxCoeff();
        if (!(largest > 0)) direction_ = Vector3d::UnitZ();
        direction_ *= 127 / direction_.cwiseAbs().maxCoeff();
        for (int axis = 0; axis < 3; ++axis) direction_[axis] = std::round(direction_[axis]);
        cell.nx = static_cast<std::int8_t>(direction_.x()), cell.ny = static_cast<std::int8_t>(direction_.y());
        cell.nz = static_cast<std::int8_t>(direction_.z());
        direction_.normalize();
    }

    /// Near `wish`; returns where.
    Vector3d set_centre(TightCell& cell, const Vector3d& wish) const
    {
        Array3d q = (127 * (wish.array() - centre_) / half_).round().max(-127.0).min(127.0);
        cell.x = static_cast<std::int8_t>(q.x()), cell.y = static_cast<std::int8_t>(q.y());
        cell.z = static_cast<std::int8_t>(q.z());
        return (centre_ + q * half_ / 127).matrix();
    }

    double radius_around(const Vector3d& centre) const
    {
        return (high_ - centre.array()).max(centre.array() - low_).matrix().norm() + margin_;
    }

    /// Of the surface in the octant along the direction, from `from` on.
    Interval extent(const Vector3d& from) const
    {
        const double reach = radius_around(from);
        const Vector3d middle = 0.5 * (low_ + high_).matrix() - from;
        const double box = (0.5 * (high_ - low_) * direction_.array().abs()).sum();
        Interval all;
        for (std::uint32_t i = 0; i < found_.count; ++i) {
            if (!(found_.masks[i] & bit_)) continue;
            const Primitive& p = surface_.primitives[found_.ids[i]];
            const Vector3d corners[3] = {point(p, 0) - from, point(p, 1) - from, point(p, 2) - from};
            Interval here;
            for (const Vector3d& corner : corners) {
                const double along = direction_.dot(corner);
                here.add({along, along});
            }
            here.cut(direction_.dot(middle), box);
            cut_to_plane(here, corners, normal(p), reach);
            if (here.low <= here.high) all.add(here); // else it only came within the slack
        }
        if (all.low > all.high) all = {-reach, reach};
        return all;
    }

    /// All of the triangle is within `off` of a plane; of that plane the ball holds a disc.
    void cut_to_plane(Interval& here, const Vector3d (&corners)[3], Vector3d n, double reach) const
    {
        if (n.squaredNorm() < 0.5) return; // too thin to have one
        n.normalize();
        const double d[3] = {n.dot(corners[0]), n.dot(corners[1]), n.dot(corners[2])};
        const double off = std::max(std::abs(d[1] - d[0]), std::abs(d[2] - d[0])) + margin_;
        const double nearest = std::max(0.0, std::abs(d[0]) - off);
        const double cosine = n.dot(direction_), sine = std::sqrt(std::max(0.0, 1 - cosine * cosine) + 1e-12);
        const double disc = std::sqrt(std::max(0.0, reach * reach - nearest * nearest));
        here.cut(d[0] * cosine, off * std::abs(cosine) + sine * disc + margin_);
    }

    const Surface& surface_;
    const TriangleSpan& found_;
    unsigned bit_;
    std::uint32_t triangles_ = 0;
    Array3d half_, centre_, low_, high_;
    double radius_, margin_;
    Vector3d direction_ = Vector3d::Zero();
};

} // namespace

TightBlock plain_block()
{
    TightBlock block;
    for (unsigned k = 0; k < 8; ++k) set(block, k, plain_cell);
    return block;
}

TightBlock bound_octants(const Surface& surface, const OctantCell& cell, const TriangleSpan& found, unsigned grey)
{
    TightBlock block = plain_block();
    if (surface.boxes) return block;
    for (; grey; grey &= grey - 1) {
        const auto k = static_cast<unsigned>(__builtin_ctz(grey));
        set(block, k, Octant(surface, cell, found, k).bound());
    }
    return block;
}

} // namespace oncollide
