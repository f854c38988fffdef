#pragma once
#include <algorithm>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/base/cpu_features.hpp>
#include <oncollide/narrowphase/boxes/obb_tree.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/exact/triangle_kernel.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/narrowphase/relative_pose.hpp>

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

/// The leaf tests of two meshes (see hierarchy.hpp): exact predicates on the file's own coordinates, those of B moved
/// into A's frame in double.
class TriangleTests {
public:
    using Pair = TrianglePair;

    void start(const ObbTree& a, const ObbTree& b, const RelativePose& b_to_a);

    template <class Found>
    bool meeting(std::span<const TrianglePair> pairs, Found found);
    double least_gap(double rounding) const;
    bool meet(TrianglePair pair) const { return triangles_meet(points_a(pair.a), points_b(pair.b)); }
    double distance(TrianglePair pair);
    double most(TrianglePair pair) const;
    double high_a(std::uint32_t triangle, const Eigen::Vector3d& line) const
    {
        const Triangle& t = triangles_a_[triangle];
        return std::max({line.dot(vertices_a_[t[0]]), line.dot(vertices_a_[t[1]]), line.dot(vertices_a_[t[2]])});
    }
    double low_b(std::uint32_t triangle, const Eigen::Vector3d& line) const
    {
        const TrianglePoints p = points_b(triangle);
        return std::min({line.dot(p[0]), line.dot(p[1]), line.dot(p[2])});
    }
    NearestPoints nearest(TrianglePair pair);

    const Triangle& corners_a(std::uint32_t triangle) const { return triangles_a_[triangle]; }
    const Triangle& corners_b(std::uint32_t triangle) const { return triangles_b_[triangle]; }
    TrianglePoints points_a(std::uint32_t triangle) const
    {
        const Triangle& t = triangles_a_[triangle];
        return {vertices_a_[t[0]], vertices_a_[t[1]], vertices_a_[t[2]]};
    }
    TrianglePoints points_b(std::uint32_t triangle) const
    {
        const Triangle& t = triangles_b_[triangle];
        return {(*b_to_a_)(vertices_b_[t[0]]), (*b_to_a_)(vertices_b_[t[1]]), (*b_to_a_)(vertices_b_[t[2]])};
    }

    struct Counts {
        std::uint64_t tested = 0; ///< pairs of triangles
        std::uint64_t unsure = 0; ///< of these, left by the filter to exact arithmetic
    };
    Counts counts;

private:
    const RelativePose* b_to_a_ = nullptr;
    const Eigen::Vector3d *vertices_a_ = nullptr, *vertices_b_ = nullptr;
    const Triangle *triangles_a_ = nullptr, *triangles_b_ = nullptr;
    std::vector<TrianglePair> barely_apart_; ///< that exact arithmetic alone could part
    alignas(64) double nearest2_[8];         ///< least squared gaps of those that the kernel found apart
};

template <class Found>
bool TriangleTests::meeting(std::span<const TrianglePair> pairs, Found found)
{
    for (; !pairs.empty(); pairs = pairs.subspan(std::min<std::size_t>(8, pairs.size()))) {
        const auto count = static_cast<unsigned>(std::min<std::size_t>(8, pairs.size()));
        CornersOfPairs corners;
        for (unsigned i = 0; i < 8; ++i) { // places past the last pair hold it once more
            const TrianglePair& pair = pairs[std::min(i, count - 1)];
            for (std::size_t k = 0; k < 3; ++k) {
                corners.a[k][i] = vertices_a_[triangles_a_[pair.a][k]].data();
                corners.b[k][i] = vertices_b_[triangles_b_[pair.b][k]].data();
            }
        }
        const PairVerdicts verdicts =
            judge_pairs()(corners, b_to_a_->rotation.data(), b_to_a_->translation.data(), nearest2_);
        counts.tested += count;
        for (unsigned rest = ~verdicts.separate & ((1u << count) - 1); rest; rest &= rest - 1) {
            const auto i = static_cast<unsigned>(__builtin_ctz(rest));
            if (!(verdicts.known >> i & 1)) {
                ++counts.unsure;
                if (!meet(pairs[i])) {
                    barely_apart_.push_back(pairs[i]);
                    continue;
                }
            }
            if (!found(pairs[i])) return false;
        }
    }
    return true;
}

} // namespace oncollide
