#include <oncollide/narrowphase/overlap/local_sides.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <Eigen/LU>

#include <oncollide/narrowphase/overlap/cut_box.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

constexpr double no_half_space = std::numeric_limits<double>::infinity();
constexpr double rounding = 0x1p-40; ///< error of unit vectors and of values computed from them, more than enough

/// True if no point within `radius` of the origin is in both half-spaces n . x >= from.
bool parted(const Vector3d& n1, double from1, const Vector3d& n2, double from2, double radius)
{
    const double most = radius * (1 + rounding), d = n1.dot(n2);
    if (from1 > most || from2 > most) return true;
    if (from1 <= 0 && from2 <= 0) return false;
    if (from1 > 0 && d * from1 >= from2) return false; // the foot on plane 1, which is near enough
    if (from2 > 0 && d * from2 >= from1) return false;
    const double sine2 = n1.cross(n2).squaredNorm();
    if (sine2 < 0x1p-60) return d < 0 && from1 + from2 > rounding * radius;
    return from1 * from1 + from2 * from2 - 2 * d * from1 * from2 > most * most * sine2 * (1 + 0x1p-8);
}

} // namespace

bool LocalSides::add(const PlacedFaces::Face& face, const Vector3d& centre, double thick)
{
    const auto range = [&](const Vector3d& normal) {
        double low = no_half_space, high = -no_half_space;
        for (const Vector3d& corner : face.corners) {
            const double at = normal.dot(corner - centre);
            low = std::min(low, at), high = std::max(high, at);
        }
        return std::pair(low, high);
    };
    for (Slab& slab : std::span(slabs_).first(std::size_t(count_))) {
        const auto [low, high] = range(slab.normal);
        const double least = std::min(low, slab.low), greatest = std::max(high, slab.high);
        if (greatest - least > thick) continue;
        slab.low = least, slab.high = greatest;
        return true;
    }
    if (count_ == most) return false;
    const auto [low, high] = range(face.normal);
    if (high - low > thick) return false; // a sliver whose normal rounding decides
    slabs_[std::size_t(count_++)] = {face.normal, low, high};
    return true;
}

int LocalSides::region_of(const Vector3d& point) const
{
    int region = 0;
    for (int k = 0; k < count_; ++k) {
        const Slab& slab = slabs_[std::size_t(k)];
        const double at = slab.normal.dot(point);
        const double margin = rounding * radius_;
        if (at > slab.high + margin)
            region |= 1 << k;
        else if (at >= slab.low - margin)
            return -1;
    }
    return region;
}

/// Sets sides_ by points of all regions. The centre's nearest point of a region is its foot on some of the planes, so
/// points beside these feet are in all regions, except very thin ones.
void LocalSides::locate(const PlacedFaces& solid, std::span<const std::uint32_t> near, const Vector3d& centre,
                        int winding)
{
    const auto look = [&](const Vector3d& point) {
        if (point.squaredNorm() > radius_ * radius_ * (1 - 0x1p-20)) return;
        const int region = region_of(point);
        if (region < 0 || sides_[std::size_t(region)] != Side::unknown) return;
        if (const auto change = solid.winding_change(centre, centre + point, near))
            sides_[std::size_t(region)] = winding + *change ? Side::inside : Side::outside;
    };
    look(Vector3d::Zero());
    for (int planes = 1; planes < 1 << count_; ++planes) {
        Eigen::Matrix<double, Eigen::Dynamic, 3, 0, most, 3> normals(std::popcount(unsigned(planes)), 3);
        Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most, 1> at(normals.rows()), signs(normals.rows());
        for (int k = 0, row = 0; k < count_; ++k)
            if (planes >> k & 1) {
                const Slab& slab = slabs_[std::size_t(k)];
                normals.row(row) = slab.normal.transpose(), at[row++] = (slab.low + slab.high) / 2;
            }
        const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most, most> gram = normals * normals.transpose();
        if (gram.determinant() < 0x1p-30) continue;
        const auto solve = gram.inverse().eval();
        const Vector3d foot = normals.transpose() * (solve * at);
        if (foot.squaredNorm() > radius_ * radius_) continue;
        for (int combination = 0; combination < 1 << normals.rows(); ++combination) {
            for (int row = 0; row < normals.rows(); ++row) signs[row] = combination >> row & 1 ? 1 : -1;
            const Vector3d way = (normals.transpose() * (solve * signs)).normalized();
            for (const double step : {0.4, 0.1, 0.02, 0.002}) look(foot + step * radius_ * way);
        }
    }
}

LocalSides::HalfSpace LocalSides::half_space(int slab, bool above, bool with) const
{
    const Slab& s = slabs_[std::size_t(slab)];
    return above ? HalfSpace{s.normal, with ? s.low : s.high} : HalfSpace{-s.normal, with ? -s.high : -s.low};
}

/// True if the ball has no point of the region that is on the given side of the slab.
bool LocalSides::empty(int region, int slab, bool above) const
{
    const HalfSpace h = half_space(slab, above, true);
    for (int k = 0; k < count_; ++k) {
        if (k == slab) continue;
        const HalfSpace other = half_space(k, region >> k & 1, true);
        if (parted(h.normal, h.from, other.normal, other.from, radius_)) return true;
    }
    return false;
}

/// A half-space beside a slab has no point of the solid if all of its regions are outside.
void LocalSides::find_holding()
{
    holding_count_ = 0;
    for (int k = 0; k < count_; ++k)
        for (const bool above : {false, true}) {
            bool out = true;
            for (int region = 0; region < 1 << count_; ++region)
                if ((region >> k & 1) == above)
                    out &= sides_[std::size_t(region)] == Side::outside || empty(region, k, above);
            if (out) holding_[std::size_t(holding_count_++)] = half_space(k, above, false);
        }
}

double LocalSides::way_across(int region, int slab, double width) const
{
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most, 1> steps(count_);
    for (int k = 0; k < count_; ++k) {
        const Slab& s = slabs_[std::size_t(k)];
        steps[k] = region >> k & 1 ? s.high - s.low : s.low - s.high; // away from the other slabs
    }
    steps[slab] = region >> slab & 1 ? -width : width;
    return std::sqrt(steps.dot(inverse_ * steps)) * (1 + rounding);
}

bool LocalSides::set(const PlacedFaces& solid, std::span<const std::uint32_t> near, const Vector3d& centre,
                     double radius, double thick, int winding)
{
    count_ = 0, radius_ = radius;
    for (const std::uint32_t face : near)
        if (!add(solid.faces()[face], centre, thick)) return false;
    sides_.fill(Side::unknown);
    locate(solid, near, centre, winding);
    find_holding();
    Eigen::Matrix<double, Eigen::Dynamic, 3, 0, most, 3> normals(count_, 3);
    for (int k = 0; k < count_; ++k) normals.row(k) = slabs_[std::size_t(k)].normal.transpose();
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most, most> gram = normals * normals.transpose();
    crossable_ = count_ > 0 && gram.determinant() > 0.05;
    if (crossable_) inverse_ = gram.inverse();
    return true;
}

/// The least of along . x for points x of the half-space within `inner` of the centre, or less; infinite if there is
/// none.
double LocalSides::reach(const HalfSpace& h, const Vector3d& along, double inner)
{
    const double d = along.dot(h.normal);
    if (h.from > inner * (1 + rounding)) return no_half_space;
    if (-inner * d >= h.from) return -inner;
    const double sine = along.cross(h.normal).norm() + 0x1p-50;
    return h.from * d - std::sqrt(std::max(0.0, inner * inner - h.from * h.from)) * sine - rounding * inner * 0x1p-8;
}

double LocalSides::depth(const LocalSides& a, const LocalSides& b, double inner, Vector3d& deep)
{
    const double margin = std::min(a.radius_, b.radius_) - inner;
    // Between two planes that face each other, no point is farther from both than from the middle.
    double between = no_half_space;
    std::array<HalfSpace, 4 * most> holding;
    std::size_t count = 0;
    for (const LocalSides* solid : {&a, &b})
        for (const HalfSpace& hold : std::span(solid->holding_).first(std::size_t(solid->holding_count_))) {
            for (std::size_t k = 0; k < count; ++k) {
                if (!(hold.normal.dot(holding[k].normal) < 0)) continue;
                const double facing = (hold.normal + holding[k].normal).norm() + rounding;
                const double middle = (hold.from + holding[k].from + facing * inner) / 2;
                if (middle >= between) continue;
                const Vector3d across = hold.normal - holding[k].normal;
                between = middle, deep = (hold.from - holding[k].from) / across.squaredNorm() * across;
            }
            holding[count++] = hold;
        }
    double depth = 0;
    for (int region_a = 0; region_a < 1 << a.count_; ++region_a) {
        if (a.sides_[std::size_t(region_a)] == Side::outside) continue;
        for (int region_b = 0; region_b < 1 << b.count_; ++region_b) {
            if (b.sides_[std::size_t(region_b)] == Side::outside) continue;
            // The least of along . x for points x of both regions, or less.
            const auto reached = [&](const Vector3d& along) {
                double least = -inner;
                for (const LocalSides* solid : {&a, &b})
                    for (int k = 0; k < solid->count_; ++k) {
                        const bool above = (solid == &a ? region_a : region_b) >> k & 1;
                        least = std::max(least, reach(solid->half_space(k, above, true), along, inner));
                    }
                return least;
            };
            double least = std::max(between, 0.0);
            for (const LocalSides* solid : {&a, &b}) {
                // A point of the solid is not in `hold`; as deep as its plane is far, it would be.
                for (const HalfSpace& hold : std::span(solid->holding_).first(std::size_t(solid->holding_count_)))
                    least = std::min(least, hold.from - reached(hold.normal));
                const int region = solid == &a ? region_a : region_b;
                for (int k = 0; k < solid->count_ && solid->crossable_; ++k) {
                    if (solid->sides_[std::size_t(region ^ 1 << k)] != Side::outside) continue;
                    const HalfSpace beyond = solid->half_space(k, !(region >> k & 1), false);
                    least = std::min(least,
                                     solid->way_across(region, k, std::max(0.0, beyond.from - reached(beyond.normal))));
                }
            }
            depth = std::max(depth, least <= margin ? least : no_half_space);
        }
    }
    return depth;
}

std::pair<double, double> LocalSides::volume(const LocalSides& a, const LocalSides& b, const Aabb& box)
{
    double lower = 0, upper = 0;
    for (int region_a = 0; region_a < 1 << a.count_; ++region_a) {
        const Side side_a = a.sides_[std::size_t(region_a)];
        if (side_a == Side::outside) continue;
        for (int region_b = 0; region_b < 1 << b.count_; ++region_b) {
            const Side side_b = b.sides_[std::size_t(region_b)];
            if (side_b == Side::outside) continue;
            const auto cut = [&](bool with) {
                CutBox rest(box);
                for (const LocalSides* solid : {&a, &b})
                    for (int k = 0; k < solid->count_; ++k) {
                        const bool above = (solid == &a ? region_a : region_b) >> k & 1;
                        const HalfSpace h = solid->half_space(k, above, with);
                        rest.keep(h.normal, h.from);
                    }
                return rest.volume();
            };
            upper += cut(true);
            if (side_a == Side::inside && side_b == Side::inside) lower += cut(false);
        }
    }
    return {lower, std::min(upper, (box.max - box.min).prod())};
}

} // namespace oncollide
