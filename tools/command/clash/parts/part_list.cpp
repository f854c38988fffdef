#include "clash/parts/part_list.hpp"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <functional>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/plain_number.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/scenes/files/scene_file.hpp>
#include <oncollide/scenes/model/box_corners.hpp>

#include "clash/parts/file_list.hpp"
#include "clash/parts/part_ids.hpp"
#include "clash/parts/part_selection.hpp"

namespace oncollide::tools {
namespace {

namespace fs = std::filesystem;

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
    std::erase_if(same, [](const auto& entry) { return entry.second.size() < 2; });
    if (same.empty()) return;
    const auto& [name, parts] = *same.begin();
    const std::string one = fmt::format("'{}', '{}'{}", shortened(list.parts[parts[0]].name),
                                        shortened(list.parts[parts[1]].name), parts.size() > 2 ? ", ..." : "");
    list.warnings.push_back(
        same.size() == 1
            ? fmt::format("{} parts are named '{}'; the report names them {}", parts.size(), shortened(name), one)
            : fmt::format("{} names occur several times, such as '{}'; the report adds their parent nodes, folders or "
                          "numbers: {}",
                          same.size(), shortened(name), one));
}

/// "Beam HEA 200 (2)" for an element of a building: the number is among the elements of this class and name.
void label_parts(PartList& list, const std::vector<Names>& names)
{
    std::map<std::string, int> count, number;
    const auto label = [&](std::size_t i) {
        const std::string &of = list.parts[i].details.part_class, &own = names[i].own;
        // Elements without a name are called by class and GlobalId.
        return class_text(of) + (own.starts_with(of + " ") ? own.substr(of.size()) : " " + own);
    };
    for (std::size_t i = 0; i < names.size(); ++i)
        if (!list.parts[i].details.part_class.empty()) ++count[label(i)];
    for (std::size_t i = 0; i < names.size(); ++i) {
        Part& part = list.parts[i];
        part.label = part.details.part_class.empty() ? part.name : label(i);
        if (count[part.label] > 1) part.label += fmt::format(" ({})", ++number[part.label]);
    }
}

/// The file's path in the folder that the command line names, or its name.
std::string path_in(const std::vector<std::string>& inputs, const std::string& file)
{
    for (const std::string& input : inputs) {
        std::error_code error;
        if (!fs::is_directory(input, error)) continue;
        const std::string below = portable_name(fs::path(file).lexically_relative(fs::path(input).lexically_normal()));
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

/// Reads files, each by load(i, threads). If some cannot be read, the first of them is reported, independent of which
/// thread failed first; with `skip`, they are dropped from `files` and their Errors are added to `unreadable`.
std::vector<Assembly> load_all(std::vector<std::string>& files, int threads, bool skip,
                               std::vector<std::string>& unreadable,
                               const std::function<Assembly(const std::string&, int)>& load)
{
    std::vector<Assembly> read(files.size());
    std::vector<std::exception_ptr> faults(files.size());
    const auto load_one = [&](std::size_t i, int inner) {
        try {
            check_format(files[i]);
            read[i] = load(files[i], inner);
        } catch (...) {
            faults[i] = std::current_exception();
        }
    };
    if (files.size() == 1)
        load_one(0, threads);
    else
        parallel_chunks(files.size(), 1, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) load_one(i, 1);
        });
    std::vector<Assembly> good;
    std::vector<std::string> good_files;
    for (std::size_t i = 0; i < files.size(); ++i) {
        try {
            if (faults[i]) std::rethrow_exception(faults[i]);
            good.push_back(std::move(read[i])), good_files.push_back(std::move(files[i]));
        } catch (const Error& error) {
            if (!skip || (error.kind() != ErrorKind::no_input && error.kind() != ErrorKind::bad_data)) throw;
            unreadable.emplace_back(error.what());
        }
    }
    files = std::move(good_files);
    return good;
}

double reach_of(const Aabb& box)
{
    return std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
}

} // namespace

PartList read_parts(const std::vector<std::string>& all_files, const Units& units, const PartRules& rules, int threads)
{
    PartList list;
    list.files = all_files, list.has_sets = !rules.set_a.empty();
    const std::vector<Assembly> read =
        load_all(list.files, threads, rules.skip_unreadable, list.unreadable, [&](const std::string& file, int inner) {
            // A single OBJ file is divided into parts, because one part could not clash.
            return load_assembly(file, {.scale = units.scale_of(file),
                                        .threads = inner,
                                        .objects = all_files.size() == 1,
                                        .most_parts = rules.most_parts});
        });
    const std::vector<std::string>& files = list.files;
    for (const std::string& line : list.unreadable) list.warnings.push_back(line + "; left out");
    if (files.empty()) throw Error(ErrorKind::no_input, fmt::format("{}: no file can be read", list.unreadable[0]));

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
    label_parts(list, names);
    make_ids_unique(list);
    selection.finish();
    // A clash lists its parts in this order: the part of set A first.
    if (list.has_sets) std::ranges::stable_partition(list.parts, [](const Part& part) { return (part.sets & 1) != 0; });
    warn_of_units(list, std::move(reaches), units.reported());
    return list;
}

double precision_of(const PartList& parts)
{
    const double far = reach_of(parts.bounds);
    // Elements of a building are placed in double, wherever the site lies.
    if (!std::ranges::all_of(parts.parts, [](const Part& part) { return !part.details.part_class.empty(); }))
        return 0x1p-19 * far;
    double size = 0;
    for (const auto& geometry : parts.meshes)
        if (geometry) size = std::max(size, reach_of(std::get<Mesh>(geometry->data).bounds));
    return std::max(0x1p-19 * size, 0x1p-45 * far);
}

double PartList::deflection() const
{
    double most = 0;
    for (const Part& part : parts) most = std::max(most, part.details.deflection);
    return most;
}

} // namespace oncollide::tools
