#include "verify/oracle/solid_truth.hpp"

#include <algorithm>
#include <cmath>

#include "verify/oracle/solid_gap.hpp"

namespace oncollide::oracle {
namespace {

using Real = long double;

/// Distance from a rectangle, negative inside; x and y are the distances beyond two of its sides.
Real from_rectangle(Real x, Real y)
{
    return std::hypot(std::max(x, 0.0L), std::max(y, 0.0L)) + std::min(std::max(x, y), 0.0L);
}

Real from_segment(Real x, Real y, Real ax, Real ay, Real bx, Real by)
{
    const Real ux = bx - ax, uy = by - ay, along = (x - ax) * ux + (y - ay) * uy;
    const Real t = std::clamp(along / (ux * ux + uy * uy), 0.0L, 1.0L);
    return std::hypot(x - ax - t * ux, y - ay - t * uy);
}

Real from_cone(const Cone& cone, const LongVector& at)
{
    const Real r = cone.radius, h = Real(cone.length) / 2, across = std::hypot(at.x(), at.y()), z = at.z();
    const Real slant = (across * 2 * h + (z - h) * r) / std::hypot(2 * h, r), base = -(z + h);
    if (slant <= 0 && base <= 0) return std::max(slant, base);
    return std::min(from_segment(across, z, 0, -h, r, -h), from_segment(across, z, r, -h, 0, h));
}

/// The nearest point y of the surface has y_i = a_i^2 x_i / (s + a_i^2 - c^2), c the least semi-axis, where s is the
/// largest root of sum (y_i / a_i)^2 = 1. The sum is convex and falls, so Newton's method from the left cannot
/// overshoot. Source: Eberly, "Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid", 2013.
Real from_ellipsoid(const Ellipsoid& ellipsoid, const LongVector& at)
{
    const LongVector a = ellipsoid.semi_axes.cast<Real>(), x = at.cwiseAbs();
    int least = 0;
    a.minCoeff(&least);
    const Real c = a[least];
    const LongVector beyond((a.x() - c) * (a.x() + c), (a.y() - c) * (a.y() + c), (a.z() - c) * (a.z() + c));
    const Real sign = x.cwiseQuotient(a).squaredNorm() < 1 ? -1 : 1;
    Real s = 0;
    for (int i = 0; i < 3; ++i) s = std::max(s, a[i] * x[i] - beyond[i]);
    const auto nearest = [&](Real root) {
        LongVector y = LongVector::Zero();
        for (int i = 0; i < 3; ++i)
            if (x[i] > 0) y[i] = a[i] * a[i] * x[i] / (root + beyond[i]);
        return y;
    };
    if (s == 0) { // in the plane across the least axis, or the axes are equal and x is the centre
        LongVector y = nearest(0);
        const Real rest = 1 - y.cwiseQuotient(a).squaredNorm();
        if (rest >= 0) {
            y[least] = c * std::sqrt(rest);
            return sign * (y - x).norm();
        }
    }
    for (int step = 0; step < 300; ++step) {
        Real sum = -1, slope = 0;
        for (int i = 0; i < 3; ++i) {
            if (x[i] == 0) continue;
            const Real q = a[i] * x[i] / (s + beyond[i]);
            sum += q * q, slope += 2 * q * q / (s + beyond[i]);
        }
        if (sum <= 0 || s + sum / slope == s) break;
        s += sum / slope;
    }
    return sign * (nearest(s) - x).norm();
}

} // namespace

SolidTruth::SolidTruth(const Shape& shape, const Eigen::Isometry3d& pose, const Eigen::Vector3d& origin)
    : shape_(shape), origin_(origin)
{
    place(pose);
    const auto axis = [&](int k) { return LongVector(turn_.col(k)); };
    const auto set = [&](Real size, bool flat) { size_ = size, flat_ = flat; };
    if (const auto* sphere = std::get_if<Sphere>(&shape_)) {
        radius_ = sphere->radius, set(2 * radius_, true);
    } else if (const auto* capsule = std::get_if<Capsule>(&shape_)) {
        radius_ = capsule->radius, set(2 * radius_ + capsule->length, true);
        edges_ = {axis(2)};
    } else if (const auto* box = std::get_if<Box>(&shape_)) {
        set(2 * box->half.cast<Real>().norm(), true);
        faces_ = edges_ = {axis(0), axis(1), axis(2)};
    } else if (const auto* cylinder = std::get_if<Cylinder>(&shape_)) {
        set(std::hypot(2 * Real(cylinder->radius), Real(cylinder->length)), false);
        faces_ = edges_ = {axis(2)};
    } else if (const auto* cone = std::get_if<Cone>(&shape_)) {
        set(std::hypot(2 * Real(cone->radius), Real(cone->length)), false);
        faces_ = edges_ = {axis(2)};
    } else if (const auto* ellipsoid = std::get_if<Ellipsoid>(&shape_)) {
        set(2 * ellipsoid->semi_axes.maxCoeff(), false);
        faces_ = edges_ = {axis(0), axis(1), axis(2)};
    } else if (const auto* hull = std::get_if<ConvexHull>(&shape_)) {
        for (const Eigen::Vector3d& p : hull->points) points_.push_back(centre_ + turn_ * p.cast<Real>());
        find_hull_faces();
        flat_ = true;
    } else {
        faces_ = {axis(2)};
    }
    if (!points_.empty()) {
        LongVector low = points_[0], high = low;
        for (const LongVector& p : points_) low = low.cwiseMin(p), high = high.cwiseMax(p);
        centre_ = (low + high) / 2, size_ = (high - low).norm();
    }
}

SolidTruth::SolidTruth(std::span<const Eigen::Vector3d> points, const Eigen::Isometry3d& pose,
                       const Eigen::Vector3d& origin)
    : shape_(ConvexHull{}), origin_(origin), flat_(true)
{
    place(pose);
    for (const Eigen::Vector3d& p : points) points_.push_back(centre_ + turn_ * p.cast<Real>());
    LongVector low = points_[0], high = low;
    for (const LongVector& p : points_) low = low.cwiseMin(p), high = high.cwiseMax(p);
    centre_ = (low + high) / 2, size_ = (high - low).norm();
}

void SolidTruth::place(const Eigen::Isometry3d& pose)
{
    turn_ = pose.linear().cast<Real>();
    centre_ = pose.translation().cast<Real>() - origin_.cast<Real>();
}

LongVector SolidTruth::local_support(const LongVector& l) const
{
    const auto round = [&](Real radius, Real z) -> LongVector {
        const Real across = std::hypot(l.x(), l.y());
        if (across == 0) return {0, 0, z};
        return {radius * l.x() / across, radius * l.y() / across, z};
    };
    if (const auto* capsule = std::get_if<Capsule>(&shape_))
        return {0, 0, std::copysign(capsule->length / 2.0L, l.z())};
    if (const auto* box = std::get_if<Box>(&shape_)) {
        const auto side = [&](int k) { return std::copysign(Real(box->half[k]), l[k]); };
        return {side(0), side(1), side(2)};
    }
    if (const auto* cylinder = std::get_if<Cylinder>(&shape_))
        return round(cylinder->radius, std::copysign(cylinder->length / 2.0L, l.z()));
    if (const auto* cone = std::get_if<Cone>(&shape_)) {
        const Real h = cone->length / 2.0L;
        if (l.z() * 2 * h > cone->radius * std::hypot(l.x(), l.y())) return {0, 0, h};
        return round(cone->radius, -h);
    }
    if (const auto* ellipsoid = std::get_if<Ellipsoid>(&shape_)) {
        const LongVector a = ellipsoid->semi_axes.cast<Real>(), al = a.cwiseProduct(l);
        const Real length = al.norm();
        return length > 0 ? LongVector(a.cwiseProduct(al) / length) : LongVector::Zero();
    }
    return LongVector::Zero(); // a sphere's centre
}

LongVector SolidTruth::core_support(const LongVector& direction) const
{
    if (points_.empty()) return centre_ + turn_ * local_support(turn_.transpose() * direction);
    const LongVector* best = &points_[0];
    Real most = direction.dot(*best);
    for (const LongVector& p : points_)
        if (const Real along = direction.dot(p); along > most) most = along, best = &p;
    return *best;
}

long double SolidTruth::height(const LongVector& unit) const
{
    if (is_half_space()) return unit.dot(centre_);
    return unit.dot(core_support(unit)) + radius_;
}

long double SolidTruth::from_surface(const LongVector& point) const
{
    if (!points_.empty()) return from_hull(point);
    const LongVector at = turn_.transpose() * (point - centre_);
    if (const auto* capsule = std::get_if<Capsule>(&shape_)) {
        const Real h = capsule->length / 2.0L;
        return LongVector(at.x(), at.y(), at.z() - std::clamp(at.z(), -h, h)).norm() - radius_;
    }
    if (const auto* box = std::get_if<Box>(&shape_)) {
        const LongVector off = at.cwiseAbs() - box->half.cast<Real>();
        return off.cwiseMax(0.0L).norm() + std::min(off.maxCoeff(), 0.0L);
    }
    if (const auto* cylinder = std::get_if<Cylinder>(&shape_))
        return from_rectangle(std::hypot(at.x(), at.y()) - cylinder->radius,
                              std::abs(at.z()) - cylinder->length / 2.0L);
    if (const auto* cone = std::get_if<Cone>(&shape_)) return from_cone(*cone, at);
    if (const auto* ellipsoid = std::get_if<Ellipsoid>(&shape_)) return from_ellipsoid(*ellipsoid, at);
    if (is_half_space()) return at.z();
    return at.norm() - radius_;
}

/// Planes through three of the points that have all others on one side.
void SolidTruth::find_hull_faces()
{
    const std::size_t count = points_.size();
    Real extent = 0, farthest = 0;
    for (const LongVector& p : points_)
        extent = std::max(extent, (p - points_[0]).norm()), farthest = std::max(farthest, p.norm());
    const Real tolerance = 1e-15L * extent + 0x1p-60L * farthest; // a small hull's coordinates have rounding, too
    const auto add = [&](const LongVector& n, Real height) {
        for (std::size_t f = 0; f < faces_.size(); ++f)
            if ((faces_[f] - n).squaredNorm() < 1e-32L && std::abs(heights_[f] - height) <= tolerance) return;
        faces_.push_back(n), heights_.push_back(height);
    };
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = i + 1; j < count; ++j)
            for (std::size_t k = j + 1; k < count; ++k) {
                const LongVector u = points_[j] - points_[i], v = points_[k] - points_[i];
                LongVector n = u.cross(v);
                const Real length = n.norm();
                if (length <= 1e-16L * u.norm() * v.norm()) continue;
                n /= length;
                const Real height = n.dot(points_[i]);
                bool above = false, below = false;
                for (std::size_t m = 0; m < count && !(above && below); ++m) {
                    const Real over = n.dot(points_[m]) - height;
                    above |= over > tolerance, below |= over < -tolerance;
                }
                if (!above) add(n, height);
                if (!below) add(-n, -height);
            }
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = i + 1; j < count; ++j) {
            const LongVector edge = points_[j] - points_[i];
            int shared = 0;
            for (std::size_t f = 0; f < faces_.size() && shared < 2; ++f)
                shared += std::abs(faces_[f].dot(points_[i]) - heights_[f]) <= tolerance &&
                          std::abs(faces_[f].dot(points_[j]) - heights_[f]) <= tolerance;
            if (shared < 2 || edge.norm() <= tolerance) continue;
            const LongVector unit = edge.normalized();
            const auto same = [&](const LongVector& e) { return e.cross(unit).squaredNorm() < 1e-32L; };
            if (std::ranges::none_of(edges_, same)) edges_.push_back(unit);
        }
}

long double SolidTruth::from_hull(const LongVector& point) const
{
    Real most = -1 - size_;
    for (std::size_t f = 0; f < faces_.size(); ++f) most = std::max(most, faces_[f].dot(point) - heights_[f]);
    if (most <= 0) return most;
    return std::max(most, gap_to(*this, point).lower); // near edges and corners the planes are nearer
}

} // namespace oncollide::oracle
