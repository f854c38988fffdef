#include "clash/parts/file_list.hpp"

#include <algorithm>
#include <filesystem>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::tools {
namespace {

namespace fs = std::filesystem;

/// Endings of files that CAD, BIM and modelling programs write, in order.
constexpr std::string_view cad_endings[] = {
    ".3dm",        ".3ds", ".3dxml",  ".arc",    ".asm",     ".blend",   ".brep", ".brp",    ".c4d",    ".catpart",
    ".catproduct", ".cgr", ".dgn",    ".dwf",    ".dwg",     ".dxf",     ".f3d",  ".f3z",    ".fbx",    ".fcstd",
    ".iam",        ".ifc", ".ifcxml", ".ifczip", ".iges",    ".igs",     ".ipt",  ".jt",     ".max",    ".mb",
    ".neu",        ".nwc", ".nwd",    ".nwf",    ".p21",     ".par",     ".pln",  ".plmxml", ".prt",    ".psm",
    ".pwd",        ".rfa", ".rvt",    ".sab",    ".sat",     ".session", ".skp",  ".sldasm", ".sldprt", ".smt",
    ".step",       ".stp", ".stpz",   ".u3d",    ".usd",     ".usda",    ".usdc", ".usdz",   ".vda",    ".vwx",
    ".wrl",        ".x3d", ".x_b",    ".x_t",    ".xmt_bin", ".xmt_txt"};

/// The ending in lower case; of a numbered version, such as shaft.prt.12, the one before the number.
std::string ending_of(const fs::path& path)
{
    const std::string ending = lower_extension(path);
    const bool numbered = ending.size() > 1 &&
                          std::ranges::all_of(ending.substr(1), [](unsigned char c) { return std::isdigit(c) != 0; });
    return numbered ? lower_extension(path.stem()) : ending;
}

bool is_mesh_file(const fs::path& path)
{
    const std::string extension = lower_extension(path);
    return !extension.empty() && std::ranges::count(mesh_extensions(), extension.substr(1)) > 0;
}

bool is_cad_file(const fs::path& path)
{
    return std::ranges::count(cad_endings, ending_of(path)) > 0;
}

/// True for files that belong to meshes: materials, textures, buffers of glTF.
bool is_beside_meshes(const fs::path& path)
{
    constexpr std::string_view kinds[] = {".mtl", ".bin", ".png", ".jpg", ".jpeg", ".webp", ".ktx2"};
    return std::ranges::count(kinds, lower_extension(path)) > 0;
}

/// ": b.txt, c.pdf"; if there are many names, the first ones; "" if there are none.
std::string colon_and(std::vector<std::string> names)
{
    constexpr std::size_t most = 20;
    if (names.empty()) return "";
    std::ranges::sort(names);
    const std::size_t more = names.size() - std::min(most, names.size());
    names.resize(names.size() - more);
    return fmt::format(": {}{}", fmt::join(names, ", "), more ? fmt::format(" and {} more", more) : "");
}

std::vector<std::string> files_below(const std::string& folder, std::vector<std::string>* warnings)
{
    std::vector<std::string> found, left_out;
    std::error_code error;
    for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        const fs::path file = at->path().lexically_normal();
        if (is_folder(file)) continue;
        if (is_regular(file) && (is_mesh_file(file) || is_cad_file(file)))
            found.push_back(file.string());
        else if (!is_beside_meshes(file))
            left_out.push_back(path_from(folder, file).string());
    }
    if (error) throw Error(ErrorKind::no_input, fmt::format("{}: {}", folder, error.message()));
    const std::string others = colon_and(std::move(left_out));
    if (found.empty())
        throw Error(ErrorKind::no_input,
                    fmt::format("{}: no mesh file in this folder ({}){}{}", folder, fmt::join(mesh_extensions(), ", "),
                                others.empty() ? "" : "; other files", others));
    if (warnings && !others.empty())
        warnings->push_back(fmt::format("{}: files that are no meshes are left out{}", folder, others));
    std::ranges::sort(found);
    return found;
}

} // namespace

std::vector<std::string> files_of(const std::vector<std::string>& inputs, std::vector<std::string>* warnings)
{
    std::vector<std::string> files;
    for (const std::string& input : inputs) {
        std::error_code error;
        if (!fs::is_directory(input, error)) {
            files.push_back(input);
            continue;
        }
        const std::vector<std::string> below = files_below(input, warnings);
        files.insert(files.end(), below.begin(), below.end());
    }
    std::set<std::string> seen;
    for (const std::string& file : files)
        if (!seen.insert(fs::path(file).lexically_normal().string()).second)
            throw Error(ErrorKind::usage, fmt::format("{}: given twice; a part would clash with itself", file));
    return files;
}

void check_format(const std::string& file)
{
    if (!is_mesh_file(file) && is_cad_file(file))
        throw Error(
            ErrorKind::no_input,
            printable(fmt::format("{}: files with the ending {} cannot be read; export the parts as glTF (.glb) "
                                  "with their names",
                                  file, ending_of(file))));
}

} // namespace oncollide::tools
