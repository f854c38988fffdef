#pragma once
#include <cmath>
#include <cstdint>

#include <oncollide/base/aabb.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>

namespace oncollide {

/// Calls visit(triangle) for all triangles that may intersect or touch a box of the mesh's frame, until it returns
/// true. Returns whether it did. Grows the tree there.
bool any_triangle(ObbTree& tree, const Aabb& box, auto visit, ObbTree::Node from = ObbTree::root)
{
    OpenBoxes boxes;
    const LaneMasks masks = tree.open(from, nullptr, boxes);
    const double rounding = 0x1p-17 * tree.radius() + 0x1p-48 * tree.centre().norm();
    for (unsigned k = 0; k < 8; ++k) {
        if (boxes.c[0][k] > 1e29f) continue; // an unused lane
        bool apart = false;
        for (int i = 0; i < 3; ++i) {
            double reach = rounding;
            for (int axis = 0; axis < 3; ++axis)
                reach += std::abs(double(boxes.axis[axis][i][k])) * double(boxes.h[axis][k]);
            const double centre = tree.centre()[i] + boxes.c[i][k];
            apart |= centre - reach > box.max[i] || centre + reach < box.min[i];
        }
        if (apart) continue;
        if (!(masks.leaves >> k & 1)) {
            if (any_triangle(tree, box, visit, tree.child(from, k))) return true;
            continue;
        }
        for (const std::uint32_t triangle : tree.primitives(from, k))
            if (visit(triangle)) return true;
    }
    return false;
}

} // namespace oncollide
