// Reading and writing OctoMap files; declared in model/occupancy_map.hpp.
#include <algorithm>
#include <sstream>

#include <fmt/format.h>
#include <octomap/OcTree.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/scenes/cooked/cooked_map.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/files/octomap_nodes.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

namespace oncollide {

namespace {

/// An octree with the probabilities. OctoMap's function for whole files prints its progress to the terminal, so it is
/// not used.
std::shared_ptr<const octomap::OcTree> octree_of(const OctomapNodes& nodes, std::string bytes, double threshold)
{
    std::istringstream in(std::move(bytes));
    in.seekg(static_cast<std::streamoff>(nodes.begin));
    const auto tree = std::make_shared<octomap::OcTree>(nodes.resolution);
    tree->setOccupancyThres(threshold);
    tree->readData(in);
    tree->updateInnerOccupancy(); // a file may mark an inner node as free although a cell in it is occupied
    return tree;
}

/// Two bits per child, depth first.
void put(const CellTree& cells, const CellTree::Node& node, std::string& bytes)
{
    unsigned bits = 0;
    for (unsigned k = 0; k < 8; ++k)
        bits |= ((node.inner | node.free) >> k & 1) << 2 * k | ((node.inner | node.occupied) >> k & 1) << (2 * k + 1);
    bytes += static_cast<char>(bits & 0xff), bytes += static_cast<char>(bits >> 8);
    for (unsigned k = 0; k < 8; ++k)
        if (node.inner >> k & 1) put(cells, cells.below(node, k), bytes);
}

} // namespace

OccupancyMap load_octomap(const std::filesystem::path& path, const MapOptions& options)
{
    constexpr std::uintmax_t most = std::uintmax_t(256) << 20; // OctoMap needs ten times the memory for a `.ot` file
    const std::string name = path.string();
    const std::string extension = lower_extension(path);
    if (extension == ".cooked") {
        if (options.unknown_is_occupied || options.occupancy_threshold)
            throw Error(ErrorKind::usage, name + ": unknown cells and the threshold are decided when a map is "
                                                 "cooked; give these options to 'oncollide cook'");
        return CookedMapChunks::map(std::make_shared<const CookedMap>(path));
    }
    std::string bytes = read_file(path, most);
    const double threshold = options.occupancy_threshold.value_or(0.5);
    if (!(threshold > 0 && threshold < 1))
        throw Error(ErrorKind::usage,
                    fmt::format("{}: the occupancy threshold is {}; it must be above 0 and below 1", name, threshold));
    if (extension == ".bt") {
        if (options.occupancy_threshold)
            throw Error(ErrorKind::usage,
                        name + ": a .bt file has no probabilities, so it takes no occupancy threshold");
        OctomapNodes nodes = read_binary_octomap(name, bytes, options.unknown_is_occupied);
        return MapAccess::make(name, std::move(nodes.cells), nodes.resolution);
    }
    if (extension != ".ot")
        throw Error(ErrorKind::bad_data,
                    fmt::format("{}: unknown kind of map file '{}'; known are bt, ot, cooked", name, extension));
    OctomapNodes nodes = read_full_octomap(name, bytes, options.unknown_is_occupied, threshold);
    OccupancyMap map = MapAccess::make(name, std::move(nodes.cells), nodes.resolution);
    map.keep(octree_of(nodes, std::move(bytes), threshold));
    return map;
}

void save_octomap(const OccupancyMap& map, const std::filesystem::path& path)
{
    const CellTree& cells = MapAccess::cells(map);
    std::string nodes;
    if (cells.top().inner & 1)
        put(cells, cells.below(cells.top(), 0), nodes);
    else
        nodes.assign(2, '\0');
    // OctoMap's own header rounds the resolution to six digits.
    OutputFile file(path);
    file.print("# Octomap OcTree binary file\n# (feel free to add / change comments, but leave the first line as it "
               "is!)\n#\nid OcTree\nsize {}\nres {}\ndata\n{}",
               cells.count(), map.resolution(), nodes);
    file.commit();
}

} // namespace oncollide
