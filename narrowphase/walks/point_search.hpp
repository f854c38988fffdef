// A first guess of a distance: two near leaves, found by going from one surface to the other and back. Nothing here is
// a bound: rounding is ignored, and nearer leaves may exist.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include <oncollide/narrowphase/obb/oriented_box_kernel.hpp>
#include <oncollide/narrowphase/walks/open_nodes.hpp>

namespace oncollide {

/// A box of an open node.
struct OpenBox {
    std::uint32_t slot, lane;

    friend bool operator==(const OpenBox&, const OpenBox&) = default;
};

constexpr OpenBox no_box{~0u, 0};

/// The leaf nearest to a point; none if floats cannot express its distance. Leaves that are large for their distance
/// count by their primitives, others by their boxes.
/// @param from  from(primitive) returns the squared distance of the primitive from the point
template <BoxHierarchy H>
OpenBox nearest_leaf(OpenNodes<H>& nodes, const OrientedBoxKernel& kernel, const float (&point)[3], auto from)
{
    constexpr float large = 0x1p-6f; // squared radius of a leaf to its squared distance
    struct Entry {
        OpenBox box;
        float distance2;
    };
    std::array<Entry, 128> stack; // boxes beyond its room are left out
    std::size_t top = 0;
    stack[top++] = {{0, 0}, 0};
    Entry found{no_box, std::numeric_limits<float>::infinity()};
    while (top) {
        const auto [box, distance2] = stack[--top];
        const auto [slot, lane] = box;
        if (distance2 >= found.distance2) continue;
        if (nodes[slot].leaf(lane)) {
            if (nodes[slot].size(lane) < large * distance2) {
                found = {box, distance2};
                continue;
            }
            for (const auto primitive : nodes.primitives(slot, lane))
                if (const auto d2 = static_cast<float>(from(primitive)); d2 < found.distance2) found = {box, d2};
            continue;
        }
        const std::uint32_t below = nodes.descend(slot, lane);
        float d2[8];
        kernel.from_point(nodes[below].boxes, point, d2);
        const std::size_t first = top;
        for (std::uint32_t k = 0; k < 8 && top < stack.size(); ++k) {
            if (!(d2[k] < found.distance2)) continue;
            std::size_t i = top++;
            for (; i > first && stack[i - 1].distance2 < d2[k]; --i) stack[i] = stack[i - 1];
            stack[i] = {{below, k}, d2[k]};
        }
    }
    return found.box;
}

/// Moves the point to the nearest point of box `k`.
inline void move_into(const OpenBoxes& boxes, unsigned k, float (&point)[3])
{
    const float d[3] = {point[0] - boxes.c[0][k], point[1] - boxes.c[1][k], point[2] - boxes.c[2][k]};
    for (int j = 0; j < 3; ++j) point[j] = boxes.c[j][k];
    for (int i = 0; i < 3; ++i) {
        const float along = d[0] * boxes.axis[i][0][k] + d[1] * boxes.axis[i][1][k] + d[2] * boxes.axis[i][2][k];
        const float in = std::clamp(along, -boxes.h[i][k], boxes.h[i][k]);
        for (int j = 0; j < 3; ++j) point[j] += in * boxes.axis[i][j][k];
    }
}

/// Finds near leaves of two geometries whose roots are open: from the centre of the smaller geometry to the nearest
/// leaf of the larger one, from there to the nearest leaf of the smaller one, and so on.
/// @param from_a, from_b  from(primitive, point) returns the squared distance
/// @param measure         called as measure(leaf of A, leaf of B, in_a, point) for each new pair of leaves; sets the
///                        point to the nearest point found so far, on A if `in_a`, else on B. False ends the search
template <BoxHierarchy A, BoxHierarchy B>
void approach(OpenNodes<A>& a, OpenNodes<B>& b, const OrientedBoxKernel& kernel, auto from_a, auto from_b, auto measure)
{
    constexpr int most_rounds = 10;
    bool in_a = b[0].size(0) <= a[0].size(0);
    const OpenBoxes& smaller = in_a ? b[0].boxes : a[0].boxes;
    float point[3] = {smaller.c[0][0], smaller.c[1][0], smaller.c[2][0]};
    OpenBox leaf_a = no_box, leaf_b = no_box;
    const auto search = [&] {
        OpenBox& leaf = in_a ? leaf_a : leaf_b;
        const OpenBox last = leaf;
        leaf = in_a ? nearest_leaf(a, kernel, point, [&](auto primitive) { return from_a(primitive, point); })
                    : nearest_leaf(b, kernel, point, [&](auto primitive) { return from_b(primitive, point); });
        return leaf != last && leaf != no_box;
    };
    if (!search()) return;
    in_a ? move_into(a[leaf_a.slot].boxes, leaf_a.lane, point) : move_into(b[leaf_b.slot].boxes, leaf_b.lane, point);
    for (int round = 0; round < most_rounds; ++round) {
        in_a = !in_a;
        if (!search() || !measure(leaf_a, leaf_b, in_a, point)) return;
    }
}

} // namespace oncollide
