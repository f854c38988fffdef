#pragma once
#include <algorithm>
#include <optional>

#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/broadphase/segment_part.hpp>
#include <oncollide/narrowphase/rays/nearest_boxes.hpp>
#include <oncollide/narrowphase/rays/ray_part.hpp>
#include <oncollide/narrowphase/rays/tree/ray_kernel.hpp>
#include <oncollide/narrowphase/rays/tree/ray_tree.hpp>

namespace oncollide {

/// The build of the kernel for this processor.
inline const RayKernel& ray_kernel()
{
    static const RayKernel kernel = ONCOLLIDE_CHOOSE_TO_AVX2(ray_kernel);
    return kernel;
}

/// Finds the triangles of a RayTree that a segment may meet, near its first point first. One thread's working memory.
class RayWalk {
public:
    /// True if walk() covers the segment, which must not be a point.
    static bool covers(const Segment& segment) { return (segment.to - segment.from).squaredNorm() > 1e-200; }
    /// Calls take(triangle, certain) for every triangle that the segment meets before the fraction `reach` of its
    /// length, and possibly for others. certain: the segment crosses the inside of the triangle, whose corners are not
    /// in one line. take() returns the new reach, as in SegmentWalk.
    /// @param segment  the segment in the mesh's frame, exact
    template <class Take>
    void walk(RayTree& tree, const Segment& segment, Take take, double reach = 1);

private:
    struct Box {
        float entry;
        std::uint32_t lane;
        RayTree::Ref node;
    };
    static RayHits hits(const RayTriangles& row, const RayPart& part, const float (&direction)[3]);
    void open(RayTree& tree, RayTree::Ref node, const RayLine& line, float last);

    NearestBoxes<Box> waiting_;
};

/// Adds the boxes of a node that the segment meets, the nearest last.
inline void RayWalk::open(RayTree& tree, RayTree::Ref node, const RayLine& line, float last)
{
    float entry[8];
    waiting_.begin_node();
    for (unsigned met = ray_kernel().boxes(tree.node(node), line, last, entry); met; met &= met - 1) {
        const auto lane = static_cast<unsigned>(__builtin_ctz(met));
        tree.prefetch_child(node, lane);
        waiting_.add({entry[lane], lane, node});
    }
}

inline RayHits RayWalk::hits(const RayTriangles& row, const RayPart& part, const float (&direction)[3])
{
    // The point of the line that is nearest to the centre of the triangles.
    const Eigen::Vector3d to_middle = part.middle - Eigen::Vector3d(row.centre[0], row.centre[1], row.centre[2]);
    const double along = to_middle.dot(part.direction), to_units = 1 / double(row.unit);
    const Eigen::Vector3d nearest = to_units * (to_middle - along * part.direction);
    const float point[3] = {float(nearest.x()), float(nearest.y()), float(nearest.z())};
    // Corners are at most 32767 sqrt(3) units from the centre, and off by 0.87 units. An area of twice a triangle errs
    // by the sides' lengths times the error of its corners, and by 18 u of the square of the lengths, with u = 2^-24.
    constexpr double reach = 57000;
    const double size = nearest.norm() + reach, error = 1 + part.error * to_units;
    RayHits hits =
        ray_kernel().triangles(row, point, direction, static_cast<float>(4 * size * error + 0x1p-18 * size * size));
    if (!part.covers(-along, reach * double(row.unit))) hits.certain = 0;
    return hits;
}

template <class Take>
void RayWalk::walk(RayTree& tree, const Segment& segment, Take take, double reach)
{
    const std::optional<SegmentPart> of_segment = part_in(segment, tree.tree().bounds());
    if (!of_segment) return;
    const RayPart part(segment, *of_segment, tree.tree().centre(), tree.tree().radius(), tree.rounding());
    float last = part.last(reach);
    if (last < 0) return;
    const float direction[3] = {float(part.direction.x()), float(part.direction.y()), float(part.direction.z())};
    waiting_.clear();
    RayTree::Ref next = tree.root();
    for (;;) {
        if (RayTree::is_rows(next)) {
            for (unsigned r = 0; r < RayTree::rows_in(next); ++r) {
                const RayTriangles& row = tree.rows(next)[r];
                auto [possible, certain] = hits(row, part, direction);
                for (; possible; possible &= possible - 1) {
                    const auto lane = static_cast<unsigned>(__builtin_ctz(possible));
                    last = std::min(last, part.last(take(row.triangle[lane], (certain >> lane & 1) != 0)));
                    if (last < 0) return;
                }
            }
        } else {
            open(tree, next, part.line, last);
        }
        Box box;
        do {
            if (waiting_.empty()) return;
            box = waiting_.take();
        } while (box.entry > last);
        next = tree.child(box.node, box.lane);
    }
}

} // namespace oncollide
