#include <oncollide/narrowphase/pairs/manifolds/shapes/few_points.hpp>

#include <algorithm>
#include <limits>

#include <Eigen/Geometry>

namespace oncollide {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// Share of the region's size, as FewPoints::choose's `place`; depths that differ by less are equal.
constexpr double same_place = 1e-6;

double turn_of(const Vector2d& u, const Vector2d& v)
{
    return u.x() * v.y() - u.y() * v.x();
}

} // namespace

double FewPoints::deepest() const
{
    double most = -std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 0; i < count_; ++i) most = std::max(most, all_[i].depth);
    return most;
}

void FewPoints::drop_shallow(double least)
{
    least = std::min(least, deepest());
    count_ = static_cast<std::uint32_t>(
        std::remove_if(all_.begin(), all_.begin() + count_, [&](const Candidate& c) { return c.depth < least; }) -
        all_.begin());
}

void FewPoints::drop_loose(double off)
{
    const auto loose = [off](const Candidate& c) { return c.off > off; };
    const auto end = std::remove_if(all_.begin(), all_.begin() + count_, loose);
    if (end != all_.begin()) count_ = static_cast<std::uint32_t>(end - all_.begin());
}

void FewPoints::choose(const Vector3d& normal, double place, std::uint32_t most)
{
    if (count_ < 2) return;
    const Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
    std::array<Vector2d, ClippedFace::most + 2> flat;
    double low_x = 1e300, high_x = -1e300, low_y = 1e300, high_y = -1e300;
    for (std::uint32_t i = 0; i < count_; ++i) {
        const double x = u.dot(all_[i].on_a), y = v.dot(all_[i].on_a);
        flat[i] = {x, y};
        low_x = std::min(low_x, x), high_x = std::max(high_x, x);
        low_y = std::min(low_y, y), high_y = std::max(high_y, y);
    }
    const Vector2d low(low_x, low_y), high(high_x, high_y);
    const double size = (high - low).norm(), same = std::max(same_place * size, place);
    if (count_ <= most && count_ <= 4) { // all, unless two are at one place
        bool apart = true;
        for (std::uint32_t i = 0; i < count_; ++i)
            for (std::uint32_t k = 0; k < i; ++k) apart &= (flat[i] - flat[k]).squaredNorm() > same * same;
        if (apart && size > 0) return;
    }
    std::array<std::uint32_t, ClippedFace::most + 2> kept;
    std::uint32_t size_kept = 0;
    std::array<double, ClippedFace::most + 2> value;
    // The first of the largest values above `least`; of equal ones the deepest.
    const auto take = [&](auto of, double least, double tie) {
        double top = -std::numeric_limits<double>::infinity();
        for (std::uint32_t i = 0; i < count_; ++i) top = std::max(top, value[i] = of(i));
        if (!(top > least) && size_kept > 0) return false;
        std::uint32_t best = count_;
        for (std::uint32_t i = 0; i < count_; ++i)
            if (value[i] >= top - tie && (best == count_ || all_[i].depth > all_[best].depth + same)) best = i;
        kept[size_kept++] = best;
        return true;
    };
    const Vector2d middle = 0.5 * (low + high);
    const double deep = deepest();
    take([&](std::uint32_t i) { return all_[i].depth >= deep - same ? (flat[i] - middle).norm() : -1; }, -2, same);
    if (most > 1) take([&](std::uint32_t i) { return (flat[i] - flat[kept[0]]).norm(); }, same, same);
    if (most > 2 && size_kept == 2) {
        const Vector2d from = flat[kept[0]], way = flat[kept[1]] - from;
        const double least = same * way.norm();
        take([&](std::uint32_t i) { return std::abs(turn_of(way, flat[i] - from)); }, least, least);
    }
    // The polygon around the kept points, counter-clockwise.
    std::array<std::uint32_t, ClippedFace::most + 3> ring;
    std::copy(kept.begin(), kept.begin() + size_kept, ring.begin());
    if (size_kept == 3 && turn_of(flat[ring[1]] - flat[ring[0]], flat[ring[2]] - flat[ring[0]]) < 0)
        std::swap(ring[1], ring[2]);
    while (size_kept > 2 && size_kept < most) { // the point that adds the largest triangle
        std::uint32_t side = 0;
        const auto outside = [&](std::uint32_t i) {
            double area = 0;
            for (std::uint32_t k = 0; k < size_kept; ++k) {
                const Vector2d &from = flat[ring[k]], &to = flat[ring[k + 1 < size_kept ? k + 1 : 0]];
                if (const double here = turn_of(flat[i] - from, to - from); here > area) area = here, side = k;
            }
            return area;
        };
        if (!take(outside, same * size, same * size)) break;
        --size_kept, outside(kept[size_kept]);
        std::copy_backward(ring.begin() + side + 1, ring.begin() + size_kept, ring.begin() + size_kept + 1);
        ring[side + 1] = kept[size_kept++];
    }
    std::array<Candidate, ClippedFace::most + 2> chosen;
    for (std::uint32_t i = 0; i < size_kept; ++i) chosen[i] = all_[kept[i]];
    std::copy(chosen.begin(), chosen.begin() + size_kept, all_.begin());
    count_ = size_kept;
}

} // namespace oncollide
