#include <oncollide/narrowphase/triangle_set.hpp>

#include <algorithm>
#include <limits>

#include <oncollide/broadphase/cpu_features.hpp>

namespace oncollide {

namespace {

FindPairs* kernel()
{
    static FindPairs* const chosen = [] {
        switch (instruction_set()) {
        case InstructionSet::avx512:
            return avx512::find_pairs();
        case InstructionSet::avx2:
            return avx2::find_pairs();
        default:
            return baseline::find_pairs();
        }
    }();
    return chosen;
}

/// A box relative to an origin, to the nearest float. Rounding keeps the order of numbers, so boxes that touch still
/// do.
FloatBox box_of(const TrianglePoints& t, const Eigen::Vector3d& origin)
{
    static constexpr double most = std::numeric_limits<float>::max();
    const auto rounded = [](double x) { return static_cast<float>(std::clamp(x, -most, most)); };
    FloatBox box;
    for (int axis = 0; axis < 3; ++axis) {
        const double x = t[0][axis], y = t[1][axis], z = t[2][axis];
        box.lo[axis] = rounded(std::min(std::min(x, y), z) - origin[axis]);
        box.hi[axis] = rounded(std::max(std::max(x, y), z) - origin[axis]);
    }
    return box;
}

constexpr std::size_t list_part = 64; ///< triangles of the list a call

} // namespace

void TriangleSet::assign(std::span<const TrianglePoints> triangles)
{
    triangles_.assign(triangles.begin(), triangles.end());
    blocks_.resize((triangles.size() + 7) / 8);
    if (triangles.empty()) return;
    origin_ = triangles.front()[0];
    constexpr float none = std::numeric_limits<float>::quiet_NaN();
    for (auto& row : blocks_.back().lo) std::fill(std::begin(row), std::end(row), none);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const FloatBox box = box_of(triangles[i], origin_);
        for (int axis = 0; axis < 3; ++axis)
            blocks_[i / 8].lo[axis][i % 8] = box.lo[axis], blocks_[i / 8].hi[axis][i % 8] = box.hi[axis];
    }
}

/// visit(pair) for pairs that meet, in order, while it returns true.
template <class Visit>
void TriangleSet::visit_meeting(std::span<const TrianglePoints> list, bool first_only, Visit visit) const
{
    static_assert(sizeof(TrianglePoints) == 9 * sizeof(double));
    if (triangles_.empty()) return;
    FloatBox boxes[list_part];
    FoundPair found[256];
    for (std::size_t begin = 0; begin < list.size(); begin += list_part) {
        const auto part = list.subspan(begin, std::min(list_part, list.size() - begin));
        for (std::size_t i = 0; i < part.size(); ++i) boxes[i] = box_of(part[i], origin_);
        const TrianglesToPair lists{
            boxes,          part.front()[0].data(),       static_cast<std::uint32_t>(part.size()),
            blocks_.data(), triangles_.front()[0].data(), static_cast<std::uint32_t>(blocks_.size())};
        for (PairCursor cursor; cursor.a < lists.count_a;) {
            const std::uint32_t count = kernel()(lists, cursor, first_only, found, std::size(found));
            for (const FoundPair& pair : std::span(found, count))
                if (pair.certain || triangles_meet(part[pair.a], triangles_[pair.b]))
                    if (!visit(TriangleMeeting{static_cast<std::uint32_t>(begin) + pair.a, pair.b})) return;
        }
    }
}

std::optional<TriangleMeeting> TriangleSet::first_meeting(std::span<const TrianglePoints> list) const
{
    std::optional<TriangleMeeting> first;
    visit_meeting(list, true, [&](const TriangleMeeting& pair) {
        first = pair;
        return false;
    });
    return first;
}

void TriangleSet::all_meeting(std::span<const TrianglePoints> list, std::vector<TriangleMeeting>& out) const
{
    out.clear();
    visit_meeting(list, false, [&](const TriangleMeeting& pair) {
        out.push_back(pair);
        return true;
    });
}

} // namespace oncollide
