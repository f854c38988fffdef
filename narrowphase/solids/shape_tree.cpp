#include <oncollide/narrowphase/solids/shape_tree.hpp>

#include <algorithm>

namespace oncollide {

LaneMasks ShapeTree::open(Node, const BoxPlacement* placement, OpenBoxes& boxes) const
{
    boxes = {};
    for (int i = 0; i < 3; ++i) {
        std::fill_n(boxes.c[i], 8, 1e30f);
        boxes.c[i][0] = placement ? placement->translation[i] : 0;
        boxes.h[i][0] = static_cast<float>(half_[i]);
        for (int axis = 0; axis < 3; ++axis)
            std::fill_n(boxes.axis[axis][i], 8, placement ? placement->rotation[3 * i + axis] : float(i == axis));
    }
    boxes.size[0] = static_cast<float>(radius_ * radius_);
    return {1, 1};
}

} // namespace oncollide
