#include <oncollide/narrowphase/tree_spheres.hpp>

#include <cmath>

namespace oncollide {

TreeSphere plain_sphere(const Ocst& tree, CellKey cell)
{
    return {tree.centre(cell), tree.radius(level_of(cell))};
}

TreeSphere tight_sphere(const Ocst& tree, CellKey cell)
{
    TreeSphere sphere = plain_sphere(tree, cell);
    if (!tree.tight() || cell == root_cell || level_of(cell) > tree.tight_levels()) return sphere;
    const TightBlock& block = tree.tight()[tree.parent_node(cell)];
    const unsigned k = octant_of(cell);
    const Eigen::Vector3d moved(block.x[k], block.y[k], block.z[k]);
    for (int axis = 0; axis < 3; ++axis)
        sphere.centre[axis] +=
            moved[axis] / 127 * std::ldexp(double(tree.root().half[std::size_t(axis)]), -level_of(cell));
    sphere.normal = Eigen::Vector3d(block.nx[k], block.ny[k], block.nz[k]).normalized();
    sphere.half = sphere.radius * block.h[k] / 255;
    sphere.radius = sphere.radius * block.r[k] / 255;
    return sphere;
}

} // namespace oncollide
