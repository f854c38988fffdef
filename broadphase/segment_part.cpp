#include <oncollide/broadphase/segment_part.hpp>

#include <algorithm>

namespace oncollide {

namespace {

using Pair = double __attribute__((vector_size(16)));

}

std::optional<SegmentPart> part_in(const Segment& segment, const Aabb& box)
{
    const Eigen::Vector3d& from = segment.from;
    const Eigen::Vector3d along = segment.to - from;
    const auto largest = [](const Eigen::Vector3d& v) { return v.cwiseAbs().maxCoeff(); };
    // Parameters err by 2^-51, which moves a point by less than half of this.
    const double rounding = 0x1p-46 * std::max(largest(from), largest(segment.to)) + 1e-300;
    const double pad = std::max(rounding, 0x1p-46 * std::max(largest(box.min), largest(box.max)));
    double begin = 0, end = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = box.min[axis] - pad - from[axis], high = box.max[axis] + pad - from[axis];
        if (along[axis] == 0) {
            if (low > 0 || high < 0) return std::nullopt;
            continue;
        }
        const Pair at = Pair{low, high} / along[axis];
        begin = std::max(begin, std::min(at[0], at[1])), end = std::min(end, std::max(at[0], at[1]));
    }
    if (begin > end) return std::nullopt;
    const bool whole = begin == 0 && end == 1;
    return SegmentPart{begin, end, 2 * (whole ? rounding : pad), from + 0.5 * (begin + end) * along,
                       0.5 * (end - begin) * along};
}

SegmentLine line_of(const SegmentPart& part, const Eigen::Vector3d& origin, double radius)
{
    // With u = 2^-24, coordinates err by 4 u radius and projections by 16 u radius; the second bounds by 24 u radius,
    // which `cross_error` exceeds.
    const double error = part.error + 0x1p-18 * radius + 1e-30, norm = part.half.norm();
    // Shorter segments count as points, because their squares may underflow.
    const double half = norm > 1e-100 ? norm : 0;
    const double scale = half > 0 ? 1 / half : 0;
    SegmentLine line{};
    for (int k = 0; k < 3; ++k) {
        line.middle[k] = static_cast<float>(part.middle[k] - origin[k]);
        line.direction[k] = static_cast<float>(part.half[k] * scale);
    }
    line.half = static_cast<float>(half * (1 + 0x1p-22));
    line.error = static_cast<float>(error * (1 + 0x1p-22)), line.cross_error = 0.5f * line.error;
    return line;
}

} // namespace oncollide
