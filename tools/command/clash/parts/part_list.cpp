#include "clash/parts/part_list.hpp"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/plain_number.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/files/scene_file.hpp>
#include <oncollide/scenes/model/box_corners.hpp>

#include "clash/parts/part_ids.hpp"
#include "clash/parts/part_selection.hpp"

namespace oncollide::tools {
namespace {

namespace fs = std::filesystem;

bool is_mesh_file(const fs::path& path)
{
    const std::string extension = lower_extension(path);
    return !extension.empty() && std::ranges::count(mesh_extensions(), extension.substr(1)) > 0;
}

/// True for files that belong to meshes: materials, textures, buffers of glTF.
bool is_beside_meshes(const fs::path& path)
{
    constexpr std::string_view kinds[] = {".mtl", ".bin", ".png", ".jpg", ".jpeg", ".webp", ".ktx2"};
    return std::ranges::count(kinds, lower_extension(path)) > 0;
}

/// ": b.ifc, c.step"; if there are many names, the first ones; "" if there are none.
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
        if (is_regular(file) && is_mesh_file(file))
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

/// The name as JSON reports store it, so that a baseline matches: bytes that are not UTF-8 become U+FFFD.
std::string valid(const std::string& name)
{
    using Json = nlohmann::json;
    return Json::parse(Json(name).dump(-1, ' ', false, Json::error_handler_t::replace)).get<std::string>();
}

/// Candidates for a part's name, the shortest first.
struct Names {
    std::string own, path, whole;
    const std::string& operator[](int level) const { return level == 0 ? own : level == 1 ? path : whole; }
};

/// Gives each part a unique name: the shortest candidate that no other part has, or a name with a number appended.
void name_parts(PartList& list, const std::vector<Names>& names)
{
    std::vector<std::uint32_t> open(names.size());
    for (std::uint32_t i = 0; i < open.size(); ++i) open[i] = i;
    std::set<std::string> taken;
    for (int level = 0; level < 3; ++level) {
        std::map<std::string, int> count;
        for (const std::uint32_t i : open) ++count[names[i][level]];
        std::vector<std::uint32_t> left;
        for (const std::uint32_t i : open) {
            const std::string& name = names[i][level];
            if (count[name] == 1 && taken.insert(name).second)
                list.parts[i].name = name;
            else
                left.push_back(i);
        }
        open = std::move(left);
    }
    std::map<std::string, int> number;
    for (const std::uint32_t i : open) {
        std::string name = names[i].path;
        while (!taken.insert(name).second) name = fmt::format("{} ({})", names[i].path, ++number[names[i].path] + 1);
        list.parts[i].name = name;
    }
    std::map<std::string, std::vector<std::uint32_t>> same;
    for (std::uint32_t i = 0; i < names.size(); ++i) same[names[i].own].push_back(i);
    for (const auto& [name, parts] : same)
        if (parts.size() > 1)
            list.warnings.push_back(fmt::format("{} parts are named '{}'; the report names them '{}', '{}'{}",
                                                parts.size(), shortened(name), shortened(list.parts[parts[0]].name),
                                                shortened(list.parts[parts[1]].name), parts.size() > 2 ? ", ..." : ""));
}

/// The file's path in the folder that the command line names, or its name.
std::string path_in(const std::vector<std::string>& inputs, const std::string& file)
{
    for (const std::string& input : inputs) {
        std::error_code error;
        if (!fs::is_directory(input, error)) continue;
        const std::string below = fs::path(file).lexically_relative(fs::path(input).lexically_normal()).string();
        if (!below.empty() && !below.starts_with("..")) return below;
    }
    return fs::path(file).filename().string();
}

/// Warns if the geometry in some files lies a hundred times nearer to the origin than in the others: they may be
/// in metres or inches while the others are in millimetres.
void warn_of_units(PartList& list, std::vector<std::pair<double, std::string>> reaches, const Unit& unit)
{
    constexpr double much = 100;
    std::ranges::sort(reaches);
    for (std::size_t k = 0; k + 1 < reaches.size(); ++k) {
        if (!(reaches[k].first > 0) || reaches[k + 1].first < much * reaches[k].first) continue;
        list.warnings.push_back(fmt::format(
            "{}{} lies within {} {} of the origin, all other files extend to {} {} or more: metres mixed with "
            "millimetres? If so, give --units '{}=m'",
            reaches[0].second, k > 0 ? fmt::format(" (and {} more)", k) : "", plain_measure(reaches[k].first, 3),
            unit.name, plain_measure(reaches[k + 1].first, 3), unit.name,
            fs::path(reaches[0].second).filename().string()));
        return;
    }
}

/// If files cannot be read, the first of them is reported, independent of which thread failed first.
template <class Load>
void load_all(std::size_t count, int threads, Load load)
{
    std::vector<std::exception_ptr> faults(count);
    parallel_chunks(count, 1, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            try {
                load(i);
            } catch (...) {
                faults[i] = std::current_exception();
            }
        }
    });
    for (const std::exception_ptr& fault : faults)
        if (fault) std::rethrow_exception(fault);
}

double reach_of(const Aabb& box)
{
    return std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
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

PartList read_parts(const std::vector<std::string>& files, const Units& units, const PartRules& rules, int threads)
{
    PartList list;
    list.files = files, list.has_sets = !rules.set_a.empty();
    std::vector<Assembly> read(files.size());
    const auto load = [&](std::size_t i, int inner) {
        // A single OBJ file is divided into parts, because one part could not clash.
        read[i] = load_assembly(files[i], {.scale = units.scale_of(files[i]),
                                           .threads = inner,
                                           .objects = files.size() == 1,
                                           .most_parts = rules.most_parts});
    };
    if (files.size() == 1)
        load(0, threads);
    else
        load_all(files.size(), threads, [&](std::size_t i) { load(i, 1); });

    PartSelection selection(list, rules);
    std::vector<Names> names;
    std::vector<std::pair<double, std::string>> reaches;
    for (std::size_t i = 0; i < files.size(); ++i) {
        const auto first = static_cast<std::uint32_t>(list.meshes.size());
        Aabb bounds;
        const std::string file_name = fs::path(files[i]).filename().string(), file = path_in(rules.inputs, files[i]);
        const bool has_nodes = is_assembly_file(files[i]) || read[i].parts.size() > 1;
        for (const AssemblyPart& part : read[i].parts) {
            const bool of_nodes = part.above != no_node_above || part.name != fs::path(files[i]).stem().string();
            names.push_back({valid(part.name), valid(of_nodes ? part.path : file_name),
                             valid(of_nodes ? files[i] + ":" + part.path : files[i])});
            const std::string path = has_nodes ? file + ":" + part.path : file;
            list.parts.push_back({.path = valid(path),
                                  .id = valid(has_nodes && files.size() == 1 ? part.path : path),
                                  .file = files[i],
                                  .mesh = first + static_cast<std::uint32_t>(part.mesh),
                                  .pose = part.pose,
                                  .details = details_of(part.extras, units.scale_of(files[i]))});
            selection.choose(part, list.parts.back());
            const auto& mesh = std::get<Mesh>(read[i].meshes[part.mesh]->data);
            list.triangles += mesh.triangles.size();
            for (const std::uint32_t corner : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u})
                bounds.add(part.pose * corner_of(mesh.bounds, corner));
        }
        list.meshes.insert(list.meshes.end(), read[i].meshes.begin(), read[i].meshes.end());
        list.bounds.add(bounds);
        reaches.emplace_back(reach_of(bounds), files[i]);
    }
    if (list.parts.size() < 2)
        throw Error(ErrorKind::bad_data,
                    fmt::format("{}: only one part ('{}'); give two files, a folder, a glTF, COLLADA or 3MF assembly "
                                "of several nodes, or an OBJ file of several objects",
                                files.front(), names.front().own));
    name_parts(list, names);
    make_ids_unique(list);
    selection.finish();
    warn_of_units(list, std::move(reaches), units.reported());
    return list;
}

} // namespace oncollide::tools
