// The steps that all questions of Traversal are made of. Private to them.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <oncollide/narrowphase/boxes/traversal.hpp>
#include <oncollide/narrowphase/exact/triangle_kernel.hpp>

namespace oncollide {

constexpr std::size_t first_batch = 4, most_batch = 64; ///< pairs of triangles tested together

inline JudgePairs* judge()
{
    static JudgePairs* const kernel = ONCOLLIDE_CHOOSE(judge_pairs);
    return kernel;
}

struct Traversal::Query {
    ObbTree &a, &b;
    const RelativePose& b_to_a;
    const Eigen::Vector3d *vertices_a, *vertices_b;
    const Triangle *triangles_a, *triangles_b;
    BoxPlacement place_b;
    double rounding;          ///< of gaps between boxes
    double triangle_rounding; ///< of distances of triangles
    double apart;             ///< of the balls around the meshes, at least

    /// Coordinates, in A's tree's frame, are at most m = |d| + rA + rB. With u = 2^-24: floats of the placement and of
    /// centres and axes moved by it err by at most 50 u m along any axis of the test; the relative pose may be 2^-19 =
    /// 32 u from a rotation (two poses, each 2^-20), by which a box's own axes are not square: 4 * 32 u of its
    /// half-extents, summed to at most sqrt 2 r. Together below 256 u m. RelativePose rounds in double, relative to the
    /// files' origins and to the bodies' distance.
    Query(ObbTree& tree_a, ObbTree& tree_b, const RelativePose& into)
        : a(tree_a), b(tree_b), b_to_a(into), vertices_a(a.mesh().vertices.data()),
          vertices_b(b.mesh().vertices.data()), triangles_a(a.mesh().triangles.data()),
          triangles_b(b.mesh().triangles.data())
    {
        const Eigen::Vector3d d = b_to_a(b.centre()) - a.centre();
        for (int i = 0; i < 9; ++i) place_b.rotation[i] = static_cast<float>(b_to_a.rotation(i / 3, i % 3));
        for (int i = 0; i < 3; ++i) place_b.translation[i] = static_cast<float>(d[i]);
        const double both = a.radius() + b.radius(), m = d.norm() + both;
        const double far = a.centre().norm() + b.centre().norm() + b_to_a.translation.norm();
        rounding = 0x1p-16 * m + 0x1p-48 * far + 1e-30;
        triangle_rounding = std::max(0x1p-38 * m, 0x1p-48 * far) + 1e-150; // squares of less underflow
        apart = d.norm() - both - rounding;
    }

    TrianglePoints points_a(std::uint32_t triangle) const
    {
        const Triangle& t = triangles_a[triangle];
        return {vertices_a[t[0]], vertices_a[t[1]], vertices_a[t[2]]};
    }
    TrianglePoints points_b(std::uint32_t triangle) const
    {
        const Triangle& t = triangles_b[triangle];
        return {b_to_a(vertices_b[t[0]]), b_to_a(vertices_b[t[1]]), b_to_a(vertices_b[t[2]])};
    }
};

inline void Traversal::start(const Query& query)
{
    a_.start(query.a, nullptr), b_.start(query.b, &query.place_b);
    waiting_.clear(), barely_apart_.clear();
    std::fill(std::begin(nearest_), std::end(nearest_), std::numeric_limits<float>::infinity());
    std::fill(std::begin(nearest_triangles2_), std::end(nearest_triangles2_), std::numeric_limits<double>::infinity());
    if (stack_.empty()) stack_.resize(64);
    stack_[0] = {0, 0, 0, 0, 0}, top_ = 1;
}

inline bool Traversal::both_leaves(const Entry& e) const
{
    return a_[e.a].leaf(e.lane_a) && b_[e.b].leaf(e.lane_b);
}

/// Of the triangles in two leaves, while visit(pair) returns true. False when it did not.
template <class Visit>
bool Traversal::each_pair(const Entry& e, Visit visit) const
{
    const BoxNode &a = *a_[e.a].node, &b = *b_[e.b].node;
    for (std::uint32_t i = 0; i < a.count[e.lane_a]; ++i)
        for (std::uint32_t j = 0; j < b.count[e.lane_b]; ++j)
            if (!visit(
                    TrianglePair{a_.tree().triangle(a.begin[e.lane_a] + i), b_.tree().triangle(b.begin[e.lane_b] + j)}))
                return false;
    return true;
}

/// Opens the larger box; pushes its parts within `reach` of the other, the nearest last. Returns how many.
template <bool far>
inline unsigned Traversal::open(const Entry& e, float reach)
{
    const bool down_a =
        b_[e.b].single(e.lane_b) || (!a_[e.a].single(e.lane_a) && a_[e.a].size(e.lane_a) >= b_[e.b].size(e.lane_b));
    const std::uint32_t slot = down_a ? a_.descend(e.a, e.lane_a) : b_.descend(e.b, e.lane_b);
    const OpenBoxes &boxes = (down_a ? a_[slot] : b_[slot]).boxes, &other = (down_a ? b_[e.b] : a_[e.a]).boxes;
    ++counts_.box_rows;
    float gaps[8];
    const auto compare = far ? oriented_box_kernel().compare_far : oriented_box_kernel().compare;
    unsigned near = compare(boxes, other, down_a ? e.lane_b : e.lane_a, reach, gaps, nearest_);
    if (!near) return 0;
    if (stack_.size() < top_ + 8) stack_.resize(2 * (top_ + 8));
    Entry* const first = &stack_[top_];
    Entry *out = first, child = e, nearest;
    for (bool any = false; near; near &= near - 1, any = true) {
        const auto k = static_cast<std::uint8_t>(__builtin_ctz(near));
        (down_a ? child.a : child.b) = slot;
        (down_a ? child.lane_a : child.lane_b) = k;
        child.gap = gaps[k];
        if (!any) {
            nearest = child;
        } else if (child.gap < nearest.gap) {
            *out++ = nearest;
            nearest = child;
        } else {
            *out++ = child;
        }
    }
    *out++ = nearest;
    const auto count = static_cast<unsigned>(out - first);
    top_ += count;
    return count;
}

/// Depth first; take_leaves(entry) for leaves within `reach`, while it returns true.
template <class TakeLeaves>
void Traversal::walk(const Query& query, float reach, TakeLeaves take_leaves)
{
    start(query);
    while (top_) {
        const Entry e = stack_[--top_];
        if (!both_leaves(e))
            open<false>(e, reach);
        else if (!take_leaves(e))
            return;
    }
}

/// found(pair) for those that meet, while it returns true. False when it did not.
template <class Found>
bool Traversal::test_waiting(const Query& query, Found found)
{
    bool go_on = true;
    for (std::size_t first = 0; first < waiting_.size() && go_on; first += 8) {
        const auto count = static_cast<unsigned>(std::min<std::size_t>(8, waiting_.size() - first));
        CornersOfPairs corners;
        for (unsigned i = 0; i < 8; ++i) { // places past the last pair hold it once more
            const TrianglePair& pair = waiting_[first + std::min(i, count - 1)];
            for (std::size_t k = 0; k < 3; ++k) {
                corners.a[k][i] = query.vertices_a[query.triangles_a[pair.a][k]].data();
                corners.b[k][i] = query.vertices_b[query.triangles_b[pair.b][k]].data();
            }
        }
        const PairVerdicts verdicts =
            judge()(corners, query.b_to_a.rotation.data(), query.b_to_a.translation.data(), nearest_triangles2_);
        counts_.triangles += count;
        for (unsigned rest = ~verdicts.separate & ((1u << count) - 1); rest && go_on; rest &= rest - 1) {
            const auto i = static_cast<unsigned>(__builtin_ctz(rest));
            const TrianglePair pair = waiting_[first + i];
            bool meet = verdicts.known >> i & 1;
            if (!meet) {
                ++counts_.unsure, meet = triangles_meet(query.points_a(pair.a), query.points_b(pair.b));
                if (!meet) barely_apart_.push_back(pair);
            }
            if (meet) go_on = found(pair);
        }
    }
    waiting_.clear();
    return go_on;
}

/// test_waiting() once `batch` pairs wait, twice as many the next time: a first meeting is likely among the first.
template <class Found>
bool Traversal::test_if_enough(const Query& query, std::size_t& batch, Found found)
{
    if (waiting_.size() < batch) return true;
    batch = std::min(2 * batch, most_batch);
    return test_waiting(query, found);
}

} // namespace oncollide
