#include <oncollide/scenes/model/occupancy_map.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

#include <fmt/format.h>
#include <octomap/OcTree.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/file_bytes.hpp>
#include <oncollide/base/output_file.hpp>
#include <oncollide/scenes/model/occupancy_cells.hpp>
#include <oncollide/scenes/model/octomap_scan.hpp>

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

OccupancyMap load_octomap(const std::filesystem::path& path)
{
    constexpr std::uintmax_t most = std::uintmax_t(256) << 20; // OctoMap needs up to a hundred times that
    const std::string name = path.string();
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    std::string bytes = read_file(path, most);
    if (extension != ".bt" && extension != ".ot")
        throw Error(ErrorKind::bad_data,
                    fmt::format("{}: unknown kind of map file '{}'; known are bt, ot", name, extension));
    const OctomapScan scan = scan_octomap(name, bytes, extension == ".bt");

    // Not OctoMap's functions for whole files: they report their progress on the terminal.
    std::istringstream in(std::move(bytes));
    in.seekg(static_cast<std::streamoff>(scan.nodes_begin));
    const auto tree = std::make_shared<octomap::OcTree>(scan.resolution);
    if (extension == ".bt")
        tree->readBinaryData(in);
    else
        tree->readData(in);
    if (!in) refuse(name, "OctoMap cannot read the file");
    tree->updateInnerOccupancy(); // a `.ot` file may say that an inner node is free though a cell in it is occupied
    return map_of(name, tree);
}

void save_octomap(const OccupancyMap& map, const std::filesystem::path& path)
{
    std::ostringstream nodes;
    if (!map.tree->writeBinaryData(nodes)) throw Error(ErrorKind::internal, "OctoMap cannot write its map");
    // OctoMap's own header rounds the resolution to six digits.
    OutputFile file(path);
    file.print("# Octomap OcTree binary file\n# (feel free to add / change comments, but leave the first line as it "
               "is!)\n#\nid OcTree\nsize {}\nres {}\ndata\n{}",
               map.tree->calcNumNodes(), map.resolution, nodes.view());
    file.commit();
}

} // namespace oncollide
