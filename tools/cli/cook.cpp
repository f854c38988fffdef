#include "cli/command.hpp"
#include "cli/cooked_tiles.hpp"
#include "cli/outputs.hpp"
#include "cli/progress.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <iostream>
#include <memory>
#include <tuple>

#include <fmt/format.h>

#include <oncollide/base/file_bytes.hpp>
#include <oncollide/base/printable.hpp>
#include <oncollide/narrowphase/cook_mesh.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/files/mesh_file.hpp>
#include <oncollide/scenes/files/terrain_file.hpp>

namespace oncollide::tools {
namespace {

namespace fs = std::filesystem;

struct CookOptions {
    std::string mesh, out, tiles;
    MeshOptions options;
    double spacing = 0, vertical_scale = 1;
    bool check = false, quiet = false;
};

/// The mesh of the file, or the surface over its heights.
Mesh read_source(const CookOptions& options)
{
    const std::string extension = lower_extension(options.mesh);
    const bool heights = !extension.empty() && std::ranges::count(terrain_extensions(), extension.substr(1)) > 0;
    if (!heights) {
        if (options.spacing != 0 || options.vertical_scale != 1)
            usage("cook: --spacing and --vertical-scale are for files of heights");
        return load_mesh(options.mesh, options.options);
    }
    if (options.options.scale != 1)
        usage("cook: --scale is for meshes; of heights --spacing and --vertical-scale tell");
    TerrainOptions terrain;
    if (options.spacing != 0) terrain.spacing = Eigen::Vector2d::Constant(options.spacing);
    terrain.vertical_scale = options.vertical_scale, terrain.centre = options.options.centre;
    return mesh_of(load_terrain(options.mesh, terrain));
}

int check_file(const CookOptions& options)
{
    if (!options.out.empty() || !options.tiles.empty() || !(options.options == MeshOptions{}))
        usage("cook: --check looks at a cooked file and writes none");
    if (options.mesh.ends_with(".json")) {
        const TilesSize size = check_tiles(options.mesh);
        if (!options.quiet)
            std::cout << fmt::format("{}: whole: {} tiles, {} triangles, {:.1f} MB\n", printable(options.mesh),
                                     size.tiles, size.triangles, double(size.bytes) / 1e6);
        return 0;
    }
    const CookedSize size = check_cooked(options.mesh);
    if (!options.quiet)
        std::cout << fmt::format("{}: whole: {} chunk{}, {:.1f} MB\n", printable(options.mesh), size.chunks,
                                 size.chunks == 1 ? "" : "s", double(size.bytes) / 1e6);
    return 0;
}

/// "100x80", or "100" for as many along y.
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
    if (options.out.empty()) usage("cook: --out FOLDER is needed");
    const auto [columns, rows] = tile_counts(options.tiles);
    const fs::path index = fs::path(options.out) / tile_index_name;
    const Mesh mesh = read_source(options);
    const MeshTiles tiles(mesh, columns, rows);
    const TilesSize size = cook_tiles(
        options.out, tiles.size(), [&](std::size_t i) { return std::pair(tiles.name(i), tiles.mesh(i)); },
        options.quiet);
    if (!options.quiet)
        std::cout << fmt::format("{}: {} triangles in {} tiles, {:.1f} MB\n", printable(index.string()), size.triangles,
                                 size.tiles, double(size.bytes) / 1e6);
    return 0;
}

int cook(const CookOptions& options)
{
    show_reading(options.quiet);
    if (options.check) return check_file(options);
    if (!options.tiles.empty()) return cook_into_tiles(options);
    if (options.out.empty()) usage("cook: --out FILE.cooked is needed");
    if (!is_cooked(options.out))
        usage(fmt::format("cook: --out {}: the name must end in .cooked, by which such files are known", options.out));
    check_files({{"--out", options.out}}, {options.mesh});
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
    const Mesh mesh = read_source(options);
    const auto read = Clock::now();
    const CookedSize size = cook_mesh(mesh, options.out);
    const auto end = Clock::now();
    const auto seconds = [](auto time) { return std::chrono::duration<double>(time).count(); };
    if (!options.quiet)
        std::cout << fmt::format(
            "{}: {} triangles in {} chunk{}, {:.1f} MB, {:.1f} bytes per triangle; read in {:.2f} s, "
            "cooked in {:.2f} s\n",
            printable(options.out), mesh.triangles.size(), size.chunks, size.chunks == 1 ? "" : "s",
            double(size.bytes) / 1e6, double(size.bytes) / double(mesh.triangles.size()), seconds(read - begin),
            seconds(end - read));
    return 0;
}

} // namespace

void add_cook(Arguments app)
{
    Arguments sub = app.add_command("cook", "Write a mesh as a cooked file, which is read where pairs come near it");
    auto options = std::make_shared<CookOptions>();
    sub.add_option("mesh", options->mesh,
                   "mesh file (OBJ, STL, PLY, OFF, glTF, COLLADA, 3MF; '-': standard input), or file of heights "
                   "(GeoTIFF, DEM, PNG, "
                   "PGM, npy), of "
                   "which the surface is cooked")
        .required()
        .type_name("FILE");
    sub.add_option("-o,--out", options->out, "cooked file to write; with --tiles a folder").type_name("FILE.cooked");
    sub.add_option("--tiles", options->tiles,
                   "cut the mesh along x and y into so many tiles, each a cooked file, with an index of them all")
        .type_name("COLUMNSxROWS");
    sub.add_option("--scale", options->options.scale, "metres per unit of the file (default 1)").type_name("S");
    sub.add_option("--spacing", options->spacing, "heights: metres between neighbours (default: what the file says)")
        .type_name("M");
    sub.add_option("--vertical-scale", options->vertical_scale, "heights: metres per unit of the file (default 1)")
        .type_name("S");
    sub.add_flag("--centre", options->options.centre, "move the middle of its box to the origin");
    sub.add_flag("--check", options->check,
                 "read all of a cooked file instead, or of all tiles of an index, and check every box");
    sub.add_flag("--quiet", options->quiet, "print nothing but errors");
    sub.footer("Examples:\n"
               "  oncollide cook terrain.ply -o terrain.cooked\n"
               "  oncollide check terrain.cooked car.obj --max-error 0.01\n"
               "  oncollide cook --check terrain.cooked\n"
               "  oncollide cook terrain.ply --tiles 100x100 -o land  # land/tiles.json\n"
               "  oncollide cook heights.png --spacing 10 --vertical-scale 0.1 --tiles 20x20 -o land\n"
               "Scene files name a cooked file as any mesh file. Results are those of the mesh that was cooked. See "
               "docs/cooked.md.");
    sub.action([options] { return cook(*options); });
}

} // namespace oncollide::tools
