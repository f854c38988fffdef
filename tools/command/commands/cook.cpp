#include "cli/command.hpp"
#include "cli/cooked_tiles.hpp"
#include "cli/outputs.hpp"
#include "cli/progress.hpp"
#include "cli/standard_output.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <memory>
#include <optional>
#include <tuple>

#include <fmt/format.h>

#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/narrowphase/cook_mesh.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>

namespace oncollide::tools {
namespace {

namespace fs = std::filesystem;

struct CookOptions {
    std::string mesh, out, tiles;
    MeshOptions options;
    double vertical_scale = 1;
    std::optional<double> spacing, no_data;
    std::string unknown = "free";
    std::optional<double> occupancy_threshold;
    bool check = false, quiet = false;
};

CookedKind kind_of(const CookOptions& options)
{
    switch (kind_of_file(options.mesh)) {
    case FileKind::cooked:
        usage(fmt::format("cook: {} is cooked already", options.mesh));
    case FileKind::map:
        return CookedKind::map;
    case FileKind::terrain:
        return CookedKind::terrain;
    default:
        return CookedKind::mesh;
    }
}

void check_options(const CookOptions& options, CookedKind kind)
{
    if (kind != CookedKind::terrain && (options.spacing || options.vertical_scale != 1 || options.no_data))
        usage("cook: --spacing, --vertical-scale and --no-data apply only to files of heights");
    if (options.unknown != "free" && options.unknown != "occupied")
        usage(fmt::format("cook: --unknown {}: expected free or occupied", options.unknown));
    if (kind != CookedKind::map && (options.unknown != "free" || options.occupancy_threshold))
        usage("cook: --unknown and --occupancy-threshold apply only to maps");
    if (kind != CookedKind::mesh && options.options.scale != 1)
        usage("cook: --scale applies only to meshes; for heights use --spacing and --vertical-scale");
    if (kind == CookedKind::map && options.options.centre) usage("cook: --centre does not apply to maps");
}

Terrain read_heights(const CookOptions& options)
{
    TerrainOptions terrain;
    if (options.spacing) terrain.spacing = Eigen::Vector2d::Constant(*options.spacing);
    terrain.vertical_scale = options.vertical_scale, terrain.centre = options.options.centre;
    terrain.no_data = options.no_data;
    return load_terrain(options.mesh, terrain);
}

/// The mesh of the file, or the surface over its heights.
Mesh read_mesh(const CookOptions& options)
{
    const CookedKind kind = kind_of(options);
    check_options(options, kind);
    if (kind == CookedKind::map)
        usage("cook: --tiles applies only to meshes and heights; maps are read cell by cell "
              "as needed");
    return kind == CookedKind::terrain ? mesh_of(read_heights(options)) : load_mesh(options.mesh, options.options);
}

int check_file(const CookOptions& options)
{
    if (!options.out.empty() || !options.tiles.empty() || !(options.options == MeshOptions{}))
        usage("cook: --check only reads a cooked file; it takes no --out, --tiles, --scale or --centre");
    if (options.mesh.ends_with(".json")) {
        const TilesSize size = check_tiles(options.mesh);
        if (!options.quiet)
            write_to_stdout(fmt::format("{}: whole: {} tiles, {} triangles, {:.1f} MB\n", printable(options.mesh),
                                        size.tiles, size.triangles, double(size.bytes) / 1e6));
        return 0;
    }
    const CookedSize size = check_cooked(options.mesh);
    if (!options.quiet)
        write_to_stdout(fmt::format("{}: whole: {} chunk{}, {:.1f} MB\n", printable(options.mesh), size.chunks,
                                    size.chunks == 1 ? "" : "s", double(size.bytes) / 1e6));
    return 0;
}

/// "100x80", or "100" for 100x100.
std::array<int, 2> tile_counts(const std::string& text)
{
    std::array<int, 2> counts{};
    const char *at = text.data(), *const end = at + text.size();
    auto [rest, error] = std::from_chars(at, end, counts[0]);
    counts[1] = counts[0];
    if (error == std::errc{} && rest != end && *rest == 'x')
        std::tie(rest, error) = [&] {
            const auto [last, fault] = std::from_chars(rest + 1, end, counts[1]);
            return std::tuple(last, fault);
        }();
    constexpr int most = 1000;
    if (error != std::errc{} || rest != end || std::min(counts[0], counts[1]) < 1 ||
        std::max(counts[0], counts[1]) > most)
        usage(fmt::format("cook: --tiles {}: expected COLUMNSxROWS, each 1 to {}", text, most));
    return counts;
}

int cook_into_tiles(const CookOptions& options)
{
    if (options.out.empty()) usage("cook: --out FOLDER is required");
    const auto [columns, rows] = tile_counts(options.tiles);
    const fs::path index = fs::path(options.out) / tile_index_name;
    const Mesh mesh = read_mesh(options);
    const MeshTiles tiles(mesh, columns, rows);
    const TilesSize size = cook_tiles(
        options.out, tiles.size(), [&](std::size_t i) { return std::pair(tiles.name(i), tiles.mesh(i)); },
        options.quiet);
    if (!options.quiet)
        write_to_stdout(fmt::format("{}: {} triangles in {} tiles, {:.1f} MB\n", printable(index.string()),
                                    size.triangles, size.tiles, double(size.bytes) / 1e6));
    return 0;
}

int cook(const CookOptions& options)
{
    show_reading(options.quiet);
    if (options.check) return check_file(options);
    if (!options.tiles.empty()) return cook_into_tiles(options);
    if (options.out.empty()) usage("cook: --out FILE.cooked is required");
    if (!is_cooked(options.out)) usage(fmt::format("cook: --out {}: the name must end in .cooked", options.out));
    check_files({{"--out", options.out}}, {options.mesh});
    using Clock = std::chrono::steady_clock;
    const CookedKind kind = kind_of(options);
    check_options(options, kind);
    const auto begin = Clock::now();
    auto read = begin;
    CookedSize size;
    std::uint64_t parts = 0; // triangles or nodes
    const auto cooked = [&](const auto& source, auto cook_it, std::uint64_t count) {
        read = Clock::now(), parts = count;
        size = cook_it(source, options.out);
    };
    if (kind == CookedKind::mesh) {
        const Mesh mesh = load_mesh(options.mesh, options.options);
        cooked(
            mesh, [](const Mesh& m, const fs::path& out) { return cook_mesh(m, out); }, mesh.triangles.size());
    } else if (kind == CookedKind::terrain) {
        const Terrain heights = read_heights(options);
        cooked(heights, cook_terrain, 2 * heights.cells());
    } else {
        const OccupancyMap map = load_octomap(options.mesh, {.unknown_is_occupied = options.unknown == "occupied",
                                                             .occupancy_threshold = options.occupancy_threshold});
        cooked(
            map, [](const OccupancyMap& m, const fs::path& out) { return cook_map(m, out); },
            MapAccess::cells(map).count());
    }
    const auto end = Clock::now();
    const auto seconds = [](auto time) { return std::chrono::duration<double>(time).count(); };
    const char* const part = kind == CookedKind::map ? "node" : "triangle";
    if (!options.quiet)
        write_to_stdout(fmt::format(
            "{}: {} {}s in {} chunk{}, {:.1f} MB, {:.2f} bytes per {}; read in {:.2f} s, cooked in {:.2f} s\n",
            printable(options.out), parts, part, size.chunks, size.chunks == 1 ? "" : "s", double(size.bytes) / 1e6,
            double(size.bytes) / double(parts), part, seconds(read - begin), seconds(end - read)));
    return 0;
}

} // namespace

void add_cook(Arguments app)
{
    Arguments sub = app.add_command(
        "cook", "Write a mesh, a map or a terrain as a cooked file, of which only the parts near other bodies are "
                "read");
    auto options = std::make_shared<CookOptions>();
    sub.add_option("mesh FILE", options->mesh,
                   "mesh file (OBJ, STL, PLY, OFF, glTF, COLLADA, 3MF; '-': standard input), or file of heights "
                   "(GeoTIFF, DEM, PNG, PGM, npy), or OctoMap (bt, ot)")
        .required();
    sub.add_option("-o,--out FILE.cooked", options->out, "cooked file to write; with --tiles a folder");
    sub.add_option("--tiles COLUMNSxROWS", options->tiles,
                   "cut the mesh along x and y into this many tiles, each a cooked file, and write an index of them");
    sub.add_option("--scale S", options->options.scale, "metres per unit of the file (default 1)");
    sub.add_option("--spacing", options->spacing, "heights: metres between neighbours (default: from the file)")
        .length();
    sub.add_option("--vertical-scale S", options->vertical_scale, "heights: metres per unit of the file (default 1)");
    sub.add_option("--no-data H", options->no_data, "heights: this value marks a hole (default: from the file)");
    sub.add_option("--unknown free|occupied", options->unknown, "maps: how to treat unknown cells (default free)");
    sub.add_option("--occupancy-threshold P", options->occupancy_threshold,
                   "maps in .ot files: least probability of an occupied cell (default 0.5)");
    sub.add_flag("--centre", options->options.centre, "move the centre of the AABB to the origin");
    sub.add_flag("--check", options->check,
                 "instead of cooking, read a whole cooked file, or all tiles of an index, and check every box");
    sub.add_flag("--quiet", options->quiet, "print only errors");
    sub.footer("Examples:\n"
               "  oncollide cook terrain.ply -o terrain.cooked\n"
               "  oncollide check terrain.cooked car.obj --max-error 0.01\n"
               "  oncollide cook --check terrain.cooked\n"
               "  oncollide cook heights.tif -o heights.cooked  # as heights, half a byte to 4 bytes per triangle\n"
               "  oncollide cook building.bt -o building.cooked\n"
               "  oncollide cook terrain.ply --tiles 100x100 -o land  # land/tiles.json\n"
               "  oncollide cook heights.png --spacing 10 --vertical-scale 0.1 --tiles 20x20 -o land\n"
               "A scene file can name a cooked file in place of its source, with the same results. See "
               "docs/cooked.md.");
    sub.action([options] { return cook(*options); });
}

} // namespace oncollide::tools
