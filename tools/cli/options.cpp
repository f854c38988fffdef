#include "cli/options.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <iostream>
#include <limits>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/output_file.hpp>
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
std::size_t parse_amount(const char* option, const std::string& text)
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

} // namespace

void add_accuracy_options(Arguments command, SettingsOptions& o)
{
    command.group("Accuracy");
    command
        .add_option(
            "--max-error", o.max_error,
            fmt::format("accuracy in metres: bodies that are 'within' a bound are at most this far apart (default: "
                        "{} % of the diagonal of the AABB of the smaller body of each pair)",
                        100 * default_error))
        .type_name("M");
    command
        .add_option("--depth", o.depth,
                    "instead of --max-error, the paper's measure of accuracy: depth of the sphere-trees, 1 to 16 "
                    "levels")
        .type_name("D");
    command.add_option("--clearance", o.clearance, "metres: bodies at most this far apart are not separate (default 0)")
        .type_name("M");
    command
        .add_option(
            "--exact", o.exact,
            fmt::format("decide exactly whether bodies collide, triangle by triangle: on (exact arithmetic; also "
                        "called predicates), off, or fcl (a cross-check: only where FCL agrees) (default {})",
                        o.exact.empty() ? "on, and off with --max-error or --depth" : o.exact))
        .type_name("on|off|predicates|fcl");
    command.add_flag("--contact-kinds,--kinds", o.kinds,
                     "report whether colliding meshes only touch or cross; needs --exact on");
    command.add_flag("--ignore-touching", o.ignore_touching,
                     "report meshes that touch without crossing as separate; needs --exact on");
    command
        .add_option("--mode", o.mode,
                    "surface, or solid: meshes must be closed and include their inside (default surface)")
        .type_name("surface|solid");
    command.add_flag("--open-as-surface", o.open_as_surface,
                     "with --mode solid: treat meshes that are not closed as surfaces");
    command.group("Options");
}

void add_pipeline_options(Arguments command, SettingsOptions& o)
{
    command.group("Computation");
    command
        .add_option("--threads", o.threads,
                    "number of threads; 0: all. Does not change the result (default "
                    "1)")
        .type_name("N");
    command
        .add_option(
            "--backend", o.backend,
            "builds the sphere-trees of meshes (finds grey cells): cpu (default), gl-compute (a GPU, the same "
            "results), gl-query (the paper's occlusion queries, which miss collisions), or auto: gl-compute on a "
            "real GPU, else cpu")
        .type_name("cpu|gl-compute|gl-query|auto");
    command.add_option("--gpu", o.gpu, "number of the GPU in the list of 'oncollide doctor' (default: the first)")
        .type_name("N");
    command.add_option("--viewport", o.viewport, "gl-query: pixels per side of a cell, 1 to 1024 (default 16)")
        .type_name("PX");
    command
        .add_option(
            "--bounding-volume,--spheres", o.bounding_volume,
            "bounding volumes of a mesh's parts: obb (oriented boxes), or sphere, as in the paper, slower at equal "
            "error (default auto: obb with --exact on, and on the cpu if the error is in metres; else sphere)")
        .type_name("auto|sphere|obb");
    command
        .add_option("--broad", o.broad,
                    "broad phase, which finds pairs of overlapping AABBs: a kd-tree, an octree, or brute force "
                    "(default kd)")
        .type_name("kd|octree|brute");
    command
        .add_option("--skip", o.skip,
                    "skip a stage: bounds, regions (delimitation), broad, refinement (refine) or exact "
                    "(repeatable); results get wider, never wrong")
        .type_name("bounds|regions|broad|refinement|exact")
        .repeatable();
    command
        .add_option("--age", o.age,
                    fmt::format("drop parts of trees that no test used for this many frames (default {})", o.age))
        .type_name("N");
    command
        .add_option("--node-budget", o.node_budget,
                    "limit on the nodes (cells) of all trees together, e.g. 2M; 0: none (default)")
        .type_name("N");
    command
        .add_option("--memory-budget", o.memory_budget,
                    "limit on the bytes of all trees together, e.g. 64M; 0: none (default). A quarter of it, 1 to 16 "
                    "MiB, is for temporary buffers")
        .type_name("BYTES");
    command
        .add_option(
            "--resident", o.resident,
            "limit on the bytes of cooked meshes in memory, e.g. 64M; 0: none (default). Changes a result only if "
            "a single pair needs more")
        .type_name("BYTES");
    command
        .add_option("--look-ahead", o.look_ahead,
                    "frames for which a prefetch thread prepares the cooked meshes and tiles that bodies will come "
                    "near, as predicted from their motion; 0: off (default). Does not change the result")
        .type_name("FRAMES");
    command.add_flag("--no-coherence", o.no_coherence,
                     "test every pair from scratch, without using results of earlier frames; same result");
    command.group("Options");
}

Settings settings_from(const SettingsOptions& o)
{
    Settings settings{.depth = o.depth,
                      .max_error = o.max_error,
                      .clearance = o.clearance,
                      .exact = exact_from_name(o.exact),
                      .contact_kinds = o.kinds,
                      .ignore_touching = o.ignore_touching,
                      .mode = mode_from_name(o.mode),
                      .open_as_surface = o.open_as_surface,
                      .backend = backend_from_name(o.backend),
                      .bounding_volume = bounding_volume_from_name(o.bounding_volume),
                      .gpu = o.gpu,
                      .viewport = o.viewport,
                      .broad_phase = broad_phase_from_name(o.broad),
                      .threads = o.threads,
                      .skip = stages_from_names(o.skip),
                      .age_limit = o.age,
                      .node_budget = parse_amount("--node-budget", o.node_budget),
                      .memory_budget = parse_amount("--memory-budget", o.memory_budget),
                      .resident_budget = parse_amount("--resident", o.resident),
                      .look_ahead = o.look_ahead,
                      .coherence = !o.no_coherence};
    check(settings);
    return settings;
}

void add_cache_options(Arguments command, CacheOptions& o)
{
    command
        .add_option("--cache", o.folder,
                    "folder of cooked meshes: mesh files are cooked into it at first use, and found by their content "
                    "afterwards")
        .type_name("DIR");
    command
        .add_option("--cache-size", o.bytes,
                    "limit on the folder's bytes; the least recently used files are removed, never the newest (default "
                    "4G)")
        .type_name("BYTES");
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
    command.add_option("--bodies", o.bodies, "catalogue: number of bodies").type_name("N");
    command.add_option("--frames", o.frames, "number of frames (default: from the scene)").type_name("N");
    command.add_option("--seed", o.seed, "catalogue: seed of the random numbers").type_name("S");
    command
        .add_option("--data", o.data,
                    "folder with meshes/ and octomap/ "
                    "(default: $ONCOLLIDE_DATA, else ../shared/data if present)")
        .type_name("DIR");
    command.group("Options");
}

void add_pace_option(Arguments command, SceneOptions& o)
{
    command.group("Scene");
    command
        .add_option("--pace", o.pace, "fraction of a frame's motion per frame played: 0.1 is slow motion (default 1)")
        .type_name("FACTOR");
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

/// Checks the options. Returns whether they mean a scene of the catalogue.
bool from_catalogue(const SceneOptions& o)
{
    check_range("--frames", o.frames.value_or(1), 1);
    if (!(o.pace > 0 && o.pace <= 1000))
        usage(fmt::format("--pace is {}; it must be above 0 and at most 1000", o.pace));
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

} // namespace

Scene open_scene(const SceneOptions& o)
{
    if (from_catalogue(o)) return opened(o, make_scene(o.scene, catalogue_options(o)));
    return opened(o, is_assembly_file(o.scene) ? load_assembly_scene(o.scene) : load_scene(o.scene, reading_of(o)));
}

SceneInfo open_scene(const SceneOptions& o, BodySink& sink)
{
    if (from_catalogue(o)) return opened(o, make_scene(o.scene, sink, catalogue_options(o)));
    if (!is_assembly_file(o.scene)) return opened(o, load_scene(o.scene, sink, reading_of(o)));
    Scene scene = opened(o, load_assembly_scene(o.scene));
    pass_bodies(scene, sink);
    return scene;
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
