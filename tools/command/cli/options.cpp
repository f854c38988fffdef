#include "cli/options.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <limits>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/pipeline/settings_table.hpp>
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

#include "cli/cooked_cache.hpp"
#include "cli/log.hpp"

namespace oncollide::tools {
namespace {

namespace fs = std::filesystem;

fs::path must_be_folder(const fs::path& path, std::string_view who)
{
    std::error_code error;
    if (!fs::is_directory(path, error))
        throw Error(ErrorKind::no_input, fmt::format("{}: '{}' is not a folder", who, path.string()));
    return path;
}

/// A count with an optional suffix K, M or G (thousands, millions, billions). CLI11 would read -1 as a very large
/// number.
std::size_t parse_amount(std::string_view option, const std::string& text)
{
    std::uint64_t value = 0, factor = 1;
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const std::string suffix(rest, text.data() + text.size());
    if (suffix == "K" || suffix == "k")
        factor = 1'000;
    else if (suffix == "M")
        factor = 1'000'000;
    else if (suffix == "G")
        factor = 1'000'000'000;
    else if (!suffix.empty())
        factor = 0;
    if (error != std::errc{} || factor == 0 || value > std::numeric_limits<std::size_t>::max() / factor)
        usage(fmt::format("{} {}: expected a whole number, 0 or more, optionally followed by K, M or G", option, text));
    return value * factor;
}

void add_option(Arguments command, const SettingRow& row, SettingsOptions::Value& value, std::string_view by_default)
{
    std::string help(row.help);
    if (!by_default.empty()) help += fmt::format(" (default {})", by_default);
    const auto add = [&](auto& field) {
        return command.add_option(fmt::format("{} {}", row.options, row.value), field, help);
    };
    switch (row.form) {
    case SettingForm::flag:
        command.add_flag(std::string(row.options), value.flag, help);
        break;
    case SettingForm::whole:
        add(value.whole);
        break;
    case SettingForm::length:
        add(value.number).length();
        break;
    case SettingForm::amount:
    case SettingForm::name:
        add(value.text);
        break;
    case SettingForm::names:
        add(value.list).repeatable();
        break;
    }
}

void add_group(Arguments command, SettingsOptions& o, std::string_view group)
{
    command.group(std::string(group));
    for (const SettingRow& row : settings_table())
        if (row.group == group) add_option(command, row, o[row.member], row.by_default);
    command.group("Options");
}

/// The value of an option; null: not given.
nlohmann::json given(const SettingRow& row, const SettingsOptions::Value& value)
{
    switch (row.form) {
    case SettingForm::flag:
        return value.flag ? nlohmann::json(!row.option_clears()) : nlohmann::json();
    case SettingForm::whole:
        return value.whole ? nlohmann::json(*value.whole) : nlohmann::json();
    case SettingForm::length:
        return value.number ? nlohmann::json(*value.number) : nlohmann::json();
    case SettingForm::amount:
        return value.text.empty() ? nlohmann::json() : nlohmann::json(parse_amount(row.option(), value.text));
    case SettingForm::name:
        return value.text.empty() ? nlohmann::json() : nlohmann::json(value.text);
    case SettingForm::names:
        return value.list.empty() ? nlohmann::json() : nlohmann::json(value.list);
    }
    return {};
}

} // namespace

SettingsOptions::SettingsOptions() : values_(settings_table().size()) {}

std::size_t SettingsOptions::index(std::string_view member)
{
    const SettingRow* row = setting_of(member);
    ONCOLLIDE_ASSERT(row);
    return static_cast<std::size_t>(row - settings_table().data());
}

void add_accuracy_options(Arguments command, SettingsOptions& o)
{
    add_group(command, o, "Accuracy");
}

void add_pipeline_options(Arguments command, SettingsOptions& o)
{
    add_group(command, o, "Computation");
}

Settings settings_from(const SettingsOptions& o)
{
    Settings settings;
    for (std::size_t i = 0; i < o.values().size(); ++i) {
        const SettingRow& row = settings_table()[i];
        if (const nlohmann::json value = given(row, o.values()[i]); !value.is_null()) row.set(settings, value);
    }
    check(settings);
    return settings;
}

void add_cache_options(Arguments command, CacheOptions& o)
{
    command.add_option(
        "--cache DIR", o.folder,
        "folder of cooked meshes: mesh files are cooked into it at first use, and found by their content afterwards");
    command.add_option(
        "--cache-size BYTES", o.bytes,
        "limit on the folder's bytes; the least recently used files are removed, never the newest (default 4G)");
}

SceneReading reading_with(const CacheOptions& o)
{
    const std::size_t most = parse_amount("--cache-size", o.bytes);
    SceneReading reading{.on_demand = true, .generators = &sample_generators()};
    if (!o.folder.empty())
        reading.cooked = [cache = CookedCache(o.folder, most)](const fs::path& mesh, const MeshOptions& options) {
            return cache.cooked(mesh, options);
        };
    return reading;
}

void add_catalogue_options(Arguments command, SceneOptions& o)
{
    command.group("Scene");
    command.add_option("--bodies N", o.bodies, "catalogue: number of bodies");
    command.add_option("--frames N", o.frames, "number of frames (default: from the scene)");
    command.add_option("--seed S", o.seed, "catalogue: seed of the random numbers");
    command.add_option("--data DIR", o.data,
                       "folder with meshes/ and octomap/ (default: $ONCOLLIDE_DATA, else ../shared/data if present)");
    command.add_option("--max-parts N", o.most_parts,
                       "assembly: limit on the parts that its instances may make, if the file writes fewer itself "
                       "(default 100000)");
    command.group("Options");
}

void add_pace_option(Arguments command, SceneOptions& o)
{
    command.group("Scene");
    command.add_option(
        "--pace FACTOR", o.pace,
        "fraction of a frame's motion per frame played: 0.1 is slow motion, 0: nothing moves (default 1)");
    command.group("Options");
}

bool is_scene_file(const std::string& text)
{
    if (text.find('/') != std::string::npos || text.ends_with(".json") || text == "-") return true;
    std::error_code error;
    const bool exists = fs::is_regular_file(text, error);
    for (const CatalogueEntry& entry : catalogue())
        if (entry.name == text) {
            if (exists)
                usage(fmt::format("'{0}' is a scene of the catalogue and also a file here; use ./{0} for the file",
                                  text));
            return false;
        }
    return exists;
}

namespace {

/// Checks the options. Returns whether the options mean a scene of the catalogue.
bool from_catalogue(const SceneOptions& o)
{
    check_range("--frames", o.frames.value_or(1), 1);
    if (!(o.pace >= 0 && o.pace <= 1000)) usage(fmt::format("--pace is {}; it must be from 0 to 1000", o.pace));
    if (!is_scene_file(o.scene)) return check_range("--bodies", o.bodies.value_or(1), 1), true;
    if (o.bodies || o.seed)
        usage(fmt::format("--{} applies only to scenes of the catalogue; '{}' is a file", o.bodies ? "bodies" : "seed",
                          o.scene));
    return false;
}

CatalogueOptions catalogue_options(const SceneOptions& o)
{
    CatalogueOptions options{.bodies = o.bodies, .frames = o.frames, .data = data_folder(o.data)};
    if (o.seed) options.seed = *o.seed;
    if (o.on_demand && !o.cache.folder.empty())
        options.tiles = [cache = CookedCache(o.cache.folder, parse_amount("--cache-size", o.cache.bytes))](
                            const std::string& name, std::size_t count, const std::function<Mesh(std::size_t)>& make) {
            return cache.tiles(name, count, make);
        };
    return options;
}

SceneReading reading_of(const SceneOptions& o)
{
    return o.on_demand ? reading_with(o.cache) : SceneReading{.generators = &sample_generators()};
}

Scene load_parts(const SceneOptions& o)
{
    check_range("--max-parts", o.most_parts, 1);
    return load_assembly_scene(o.scene, {.most_parts = std::size_t(o.most_parts)});
}

/// Applies the options that all scenes have, and logs the size.
template <class AnyScene>
AnyScene opened(const SceneOptions& o, AnyScene scene)
{
    if (o.frames) scene.frames = *o.frames;
    scene.pace = o.pace;
    if (logged(LogLevel::info))
        log(LogLevel::info, fmt::format("scene '{}': {} bodies, {} geometries, {} frames", scene.name, scene.size(),
                                        scene.geometries.size(), scene.frames));
    return scene;
}

/// As read(), but errors name the formats of scenes if the file's name has another format.
template <class Read>
auto of_known_format(const SceneOptions& o, Read read)
{
    const std::string extension = lower_extension(o.scene);
    try {
        return read();
    } catch (const Error& error) {
        if (extension.empty() || extension == ".json" || is_assembly_file(o.scene)) throw;
        throw Error(error.kind(), fmt::format("{}; a scene is a file .json, .gltf, .glb, .dae or .3mf, or a name of "
                                              "'oncollide scene --list'",
                                              error.what()));
    }
}

} // namespace

Scene open_scene(const SceneOptions& o)
{
    return of_known_format(o, [&] {
        if (from_catalogue(o)) return opened(o, make_scene(o.scene, catalogue_options(o)));
        return opened(o, is_assembly_file(o.scene) ? load_parts(o) : load_scene(o.scene, reading_of(o)));
    });
}

SceneInfo open_scene(const SceneOptions& o, BodySink& sink)
{
    if (!is_assembly_file(o.scene))
        return of_known_format(o, [&] {
            if (from_catalogue(o)) return opened(o, make_scene(o.scene, sink, catalogue_options(o)));
            return opened(o, load_scene(o.scene, sink, reading_of(o)));
        });
    Scene scene = opened(o, load_parts(o));
    pass_bodies(scene, sink);
    return scene;
}

void must_be_rigid(const Scene& scene, const char* command)
{
    const std::span<const std::uint32_t> deforming = scene.geometries.deforming();
    if (!deforming.empty())
        usage(
            fmt::format("{}: geometry '{}' deforms, and this command compares rigid geometries; 'oncollide run' plays "
                        "the scene",
                        command, printable(scene.geometries[deforming.front()].name)));
}

fs::path data_folder(const std::string& option)
{
    if (!option.empty()) return must_be_folder(option, "--data");
    if (const char* variable = std::getenv("ONCOLLIDE_DATA"); variable && *variable)
        return must_be_folder(variable, "ONCOLLIDE_DATA");
    std::error_code error;
    return fs::is_directory("../shared/data", error) ? fs::path("../shared/data") : fs::path();
}

void print_warnings(const Scene& scene)
{
    log_warnings(scene.warnings);
}

} // namespace oncollide::tools
