#include <oncollide/narrowphase/obb/shape_tree.hpp>

#include <algorithm>

namespace oncollide {

LaneMasks ShapeTree::open(Node, const BoxPlacement* placement, OpenBoxes& boxes) const
{
    boxes = {};
    for (int i = 0; i < 3; ++i) {
        std::fill_n(boxes.c[i], 8, 1e30f);
        boxes.h[i][0] = static_cast<float>(half_[i]);
        boxes.margin += box_margin * boxes.h[i][0];
        const float* const r = placement && placement->rotated ? placement->rotation + 3 * i : nullptr;
        boxes.c[i][0] = !placement ? 0 : !r ? -placement->from[i] : placement->translation[i];
        for (int axis = 0; axis < 3; ++axis) {
            if (r) boxes.c[i][0] -= r[axis] * placement->from[axis];
            std::fill_n(boxes.axis[axis][i], 8, r ? r[axis] : float(i == axis));
        }
    }
    boxes.size[0] = static_cast<float>(radius_ * radius_);
    return {1, 1};
}

} // namespace oncollide
