#pragma once
#include <algorithm>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/exact/kernels/segment_kernel.hpp>
#include <oncollide/narrowphase/exact/kernels/triangle_kernel.hpp>
#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/narrowphase/obb/terrain_tree.hpp>

namespace oncollide {

/// Triangles a and b of two meshes, by number.
struct TrianglePair {
    std::uint32_t a, b;

    friend auto operator<=>(const TrianglePair&, const TrianglePair&) = default;
};

inline JudgePairs* judge_pairs()
{
    static JudgePairs* const kernel = ONCOLLIDE_CHOOSE(judge_pairs);
    return kernel;
}

inline CommonSegments* common_segments()
{
    static CommonSegments* const kernel = ONCOLLIDE_CHOOSE(common_segments);
    return kernel;
}

/// The corners of a hierarchy's triangles, in the form that the tests need: pointers to where they are stored.
template <class Tree>
class TriangleCorners;

template <>
class TriangleCorners<ObbTree> {
public:
    void start(const ObbTree& tree) { vertices_ = tree.vertices(), triangles_ = tree.triangles(); }
    TrianglePoints points(std::uint32_t triangle) const
    {
        const Triangle& t = triangles_[triangle];
        return {vertices_[t[0]], vertices_[t[1]], vertices_[t[2]]};
    }
    /// Stores pointers to the triangle's corners as pair `i` of the kernel's input.
    void put(std::uint32_t triangle, unsigned i, const double* (&corners)[3][8])
    {
        for (std::size_t k = 0; k < 3; ++k) corners[k][i] = vertices_[triangles_[triangle][k]].data();
    }

private:
    const Eigen::Vector3d* vertices_ = nullptr;
    const Triangle* triangles_ = nullptr;
};

/// The corners of a terrain's triangles are computed when needed.
template <>
class TriangleCorners<TerrainTree> {
public:
    void start(const TerrainTree& tree) { tree_ = &tree; }
    TrianglePoints points(std::uint32_t triangle) const { return tree_->points(triangle); }
    void put(std::uint32_t triangle, unsigned i, const double* (&corners)[3][8])
    {
        if (i == 0 || triangle != last_) made_[at_ = i] = points(last_ = triangle);
        for (std::size_t k = 0; k < 3; ++k) corners[k][i] = made_[at_][k].data();
    }

private:
    const TerrainTree* tree_ = nullptr;
    std::array<TrianglePoints, 8> made_;
    std::uint32_t last_ = 0;
    unsigned at_ = 0;
};

/// The leaf tests of meshes and terrains (see hierarchy.hpp): exact predicates on their own coordinates; B's are moved
/// into A's frame in double.
template <class A, class B>
class TriangleTestsOf {
public:
    using Pair = TrianglePair;

    void start(const A& a, const B& b, const RelativePose& b_to_a);

    template <class Found>
    bool meeting(std::span<const TrianglePair> pairs, Found found);
    double least_gap(double rounding) const;
    /// Common segments of up to eight pairs that meet; see CommonSegments.
    unsigned segments(std::span<const TrianglePair> pairs, const RigidMap& place, SegmentsOfPairs& out);
    bool meet(TrianglePair pair) const { return triangles_meet(points_a(pair.a), points_b(pair.b)); }
    double most(TrianglePair pair) const;
    double high_a(std::uint32_t triangle, const Eigen::Vector3d& line) const
    {
        return most_along(line, a_.points(triangle));
    }
    double low_b(std::uint32_t triangle, const Eigen::Vector3d& line) const
    {
        return least_along(line, b_.points(triangle));
    }
    /// The squared distance of a point of A's frame from a triangle, without an error bound.
    double from_a(std::uint32_t triangle, const Eigen::Vector3d& point) const
    {
        return (nearest_on(a_.points(triangle), point).at - point).squaredNorm();
    }
    double from_b(std::uint32_t triangle, const Eigen::Vector3d& point) const
    {
        const Eigen::Vector3d in_b = b_to_a_->rotation.transpose() * (point - b_to_a_->translation);
        return (nearest_on(b_.points(triangle), in_b).at - in_b).squaredNorm();
    }
    NearestPoints nearest(TrianglePair pair, double rounding);
    /// Calls take(pair, points) for each pair.
    template <class Take>
    void nearest(std::span<const TrianglePair> pairs, double rounding, Take take);

    TrianglePoints points_a(std::uint32_t triangle) const { return a_.points(triangle); }
    TrianglePoints points_b(std::uint32_t triangle) const
    {
        TrianglePoints points = b_.points(triangle);
        for (Eigen::Vector3d& p : points) p = (*b_to_a_)(p);
        return points;
    }

    struct Counts {
        std::uint64_t tested = 0; ///< pairs of triangles
        std::uint64_t unsure = 0; ///< pairs that the filter left to exact arithmetic
    };
    Counts counts;

private:
    /// The corners of up to eight pairs; unused lanes repeat the last pair.
    CornersOfPairs corners_of(std::span<const TrianglePair> pairs)
    {
        CornersOfPairs corners;
        for (unsigned i = 0; i < 8; ++i) {
            const TrianglePair& pair = pairs[std::min<std::size_t>(i, pairs.size() - 1)];
            a_.put(pair.a, i, corners.a), b_.put(pair.b, i, corners.b);
        }
        return corners;
    }
    template <class Take>
    bool each_eight(std::span<const TrianglePair> pairs, Take take);

    const RelativePose* b_to_a_ = nullptr;
    TriangleCorners<A> a_;
    TriangleCorners<B> b_;
    std::vector<TrianglePair> barely_apart_; ///< only exact arithmetic could separate them
    alignas(64) double nearest2_[8];         ///< least squared gaps of the pairs that the kernel found apart
    bool met_ = false;                       ///< true once a pair met: gaps then no longer count
};
using TriangleTests = TriangleTestsOf<ObbTree, ObbTree>;

/// Calls take(first pairs, their corners) for eight pairs at a time, while it returns true. Returns whether it always
/// did.
template <class A, class B>
template <class Take>
bool TriangleTestsOf<A, B>::each_eight(std::span<const TrianglePair> pairs, Take take)
{
    for (; !pairs.empty(); pairs = pairs.subspan(std::min<std::size_t>(8, pairs.size()))) {
        const auto count = static_cast<unsigned>(std::min<std::size_t>(8, pairs.size()));
        counts.tested += count;
        if (!take(pairs.first(count), corners_of(pairs.first(count)))) return false;
    }
    return true;
}

template <class A, class B>
template <class Take>
void TriangleTestsOf<A, B>::nearest(std::span<const TrianglePair> all, double rounding, Take take)
{
    each_eight(all, [&](std::span<const TrianglePair> pairs, const CornersOfPairs& corners) {
        NearestOfPairs points;
        measure_pairs(corners, *b_to_a_, static_cast<unsigned>(pairs.size()), rounding, points);
        for (unsigned i = 0; i < pairs.size(); ++i) take(pairs[i], points_of(points, i));
        return true;
    });
}

template <class A, class B>
template <class Found>
bool TriangleTestsOf<A, B>::meeting(std::span<const TrianglePair> all, Found found)
{
    return each_eight(all, [&](std::span<const TrianglePair> pairs, const CornersOfPairs& corners) {
        const PairVerdicts verdicts =
            judge_pairs()(corners, b_to_a_->rotation.data(), b_to_a_->translation.data(), met_ ? nullptr : &nearest2_);
        for (unsigned rest = ~verdicts.separate & ((1u << pairs.size()) - 1); rest; rest &= rest - 1) {
            const auto i = static_cast<unsigned>(__builtin_ctz(rest));
            if (!(verdicts.known >> i & 1)) {
                ++counts.unsure;
                if (!meet(pairs[i])) {
                    barely_apart_.push_back(pairs[i]);
                    continue;
                }
            }
            met_ = true;
            if (!found(pairs[i])) return false;
        }
        return true;
    });
}

} // namespace oncollide
