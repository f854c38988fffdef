#include <oncollide/narrowphase/triangle_set.hpp>

#include <algorithm>
#include <limits>

#include <oncollide/broadphase/cpu_features.hpp>

namespace oncollide {

namespace {

MeetingTriangles* kernel()
{
    static MeetingTriangles* const chosen = [] {
        switch (instruction_set()) {
        case InstructionSet::avx512:
            return avx512::meeting_triangles();
        case InstructionSet::avx2:
            return avx2::meeting_triangles();
        default:
            return baseline::meeting_triangles();
        }
    }();
    return chosen;
}

constexpr double most = std::numeric_limits<float>::max();
constexpr float least = std::numeric_limits<float>::min();

/// A float not above the exact difference that rounded to x: the cast errs by 2^-24 of the magnitude or less than
/// `least`, the difference by 2^-53 of it.
float below(double x)
{
    if (x < -most) return -std::numeric_limits<float>::infinity();
    const auto f = static_cast<float>(std::min(x, most));
    return f - std::abs(f) * 0x1p-22f - least;
}
float above(double x)
{
    return -below(-x);
}

/// The triangle's box relative to the origin, rounded outward: set(axis, lo, hi).
template <class Set>
void bound(const TrianglePoints& t, const Eigen::Vector3d& origin, Set set)
{
    for (int axis = 0; axis < 3; ++axis) {
        const double x = t[0][axis], y = t[1][axis], z = t[2][axis];
        set(axis, below(std::min({x, y, z}) - origin[axis]), above(std::max({x, y, z}) - origin[axis]));
    }
}

constexpr std::uint32_t blocks_a_call = 32;

/// visit(i) for triangles that meet the query, ascending, while it returns true.
template <class Visit>
void visit_meeting(const TriangleQuery& query, const TrianglePoints& triangle, std::span<const BoxBlock> blocks,
                   std::span<const TrianglePoints> triangles, bool first_only, Visit visit)
{
    static_assert(sizeof(TrianglePoints) == 9 * sizeof(double));
    const auto count = static_cast<std::uint32_t>(blocks.size());
    std::uint32_t entries[8 * blocks_a_call];
    for (std::uint32_t begin = 0; begin < count; begin += blocks_a_call) {
        const std::uint32_t end = std::min(count, begin + blocks_a_call);
        const std::uint32_t found =
            kernel()(query, blocks.data(), triangles.front()[0].data(), begin, end, first_only, entries);
        for (std::uint32_t k = 0; k < found; ++k) {
            const std::uint32_t i = entries[k] >> 1;
            const bool certain = !(entries[k] & 1);
            if ((certain || triangles_meet(triangle, triangles[i])) && !visit(i)) return;
        }
    }
}

} // namespace

void TriangleSet::assign(std::span<const TrianglePoints> triangles)
{
    triangles_.assign(triangles.begin(), triangles.end());
    blocks_.resize((triangles.size() + 7) / 8);
    if (triangles.empty()) return;
    origin_ = triangles.front()[0];
    constexpr float none = std::numeric_limits<float>::quiet_NaN();
    for (auto& row : blocks_.back().lo) std::fill(std::begin(row), std::end(row), none);
    for (std::size_t i = 0; i < triangles.size(); ++i)
        bound(triangles[i], origin_, [&](int axis, float lo, float hi) {
            blocks_[i / 8].lo[axis][i % 8] = lo, blocks_[i / 8].hi[axis][i % 8] = hi;
        });
}

TriangleQuery TriangleSet::query_of(const TrianglePoints& triangle) const
{
    TriangleQuery query{triangle[0].data(), {}, {}};
    bound(triangle, origin_, [&](int axis, float lo, float hi) { query.lo[axis] = lo, query.hi[axis] = hi; });
    return query;
}

std::optional<std::uint32_t> TriangleSet::first_meeting(const TrianglePoints& triangle) const
{
    std::optional<std::uint32_t> first;
    visit_meeting(query_of(triangle), triangle, blocks_, triangles_, true, [&](std::uint32_t i) {
        first = i;
        return false;
    });
    return first;
}

void TriangleSet::all_meeting(const TrianglePoints& triangle, std::vector<std::uint32_t>& out) const
{
    out.clear();
    visit_meeting(query_of(triangle), triangle, blocks_, triangles_, false, [&](std::uint32_t i) {
        out.push_back(i);
        return true;
    });
}

} // namespace oncollide
