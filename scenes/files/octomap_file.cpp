// Reading and writing OctoMap's files; declared in model/occupancy_map.hpp.
#include <algorithm>
#include <sstream>

#include <fmt/format.h>
#include <octomap/OcTree.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/file_bytes.hpp>
#include <oncollide/base/output_file.hpp>
#include <oncollide/scenes/files/octomap_scan.hpp>
#include <oncollide/scenes/model/occupancy_cells.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>

namespace oncollide {

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
