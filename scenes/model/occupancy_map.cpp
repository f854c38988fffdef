#include <oncollide/scenes/model/occupancy_map.hpp>

#include <cmath>

#include <fmt/format.h>
#include <octomap/OcTree.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/occupancy_cells.hpp>

namespace oncollide {

namespace {

/// Boxes from the leaves' integer keys, in double: neighbours share their faces exactly. (OctoMap's own coordinates are
/// floats.)
Aabb cell_box(const octomap::OcTree::leaf_iterator& leaf, double resolution)
{
    const int side = 1 << (16 - leaf.getDepth()); // in smallest cells
    Aabb box;
    for (unsigned axis = 0; axis < 3; ++axis) {
        const int low = (leaf.getKey()[axis] & ~(side - 1)) - 32768;
        box.min[axis] = low * resolution, box.max[axis] = (low + side) * resolution;
    }
    return box;
}

void check_tree(const std::string& name, const octomap::OcTree& tree)
{
    if (!(tree.getResolution() >= least_resolution && tree.getResolution() <= most_resolution))
        throw Error(ErrorKind::bad_data, fmt::format("{}: the resolution is {}; it must be from {} to {} m", name,
                                                     tree.getResolution(), least_resolution, most_resolution));
    if (tree.size() == 0) refuse(name, "the map is empty");
    for (auto node = tree.begin_tree(), end = tree.end_tree(); node != end; ++node) {
        if (!std::isfinite(node->getLogOdds())) refuse(name, "an occupancy is not finite");
        if (tree.nodeHasChildren(&*node) && !tree.isNodeOccupied(*node) &&
            node->getMaxChildLogOdds() >= tree.getOccupancyThresLog())
            refuse(name, "an inner node is free though a cell in it is occupied; call updateInnerOccupancy() first");
    }
}

} // namespace

OccupancyMap map_of(const std::string& name, std::shared_ptr<const octomap::OcTree> tree)
{
    OccupancyMap map;
    map.resolution = tree->getResolution();
    for (auto leaf = tree->begin_leafs(), end = tree->end_leafs(); leaf != end; ++leaf)
        if (tree->isNodeOccupied(*leaf)) {
            map.cells.push_back(cell_box(leaf, map.resolution));
            map.bounds.add(map.cells.back());
        }
    if (map.cells.empty()) refuse(name, "no cell of the map is occupied");
    map.tree = std::move(tree);
    return map;
}

OccupancyMap make_occupancy_map(const octomap::OcTree& tree)
{
    const auto copy = std::make_shared<octomap::OcTree>(tree);
    copy->updateInnerOccupancy();
    return make_occupancy_map(std::shared_ptr<const octomap::OcTree>(copy));
}

OccupancyMap make_occupancy_map(std::shared_ptr<const octomap::OcTree> tree)
{
    const std::string name = "octree";
    if (!tree) refuse(name, "there is none");
    check_tree(name, *tree);
    return map_of(name, std::move(tree));
}

} // namespace oncollide
