#include "cli/command.hpp"
#include "cli/outputs.hpp"

#include <chrono>
#include <iostream>
#include <memory>

#include <fmt/format.h>

#include <oncollide/base/printable.hpp>
#include <oncollide/narrowphase/cook_mesh.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/files/mesh_file.hpp>

namespace oncollide::tools {
namespace {

struct CookOptions {
    std::string mesh, out;
    MeshOptions options;
    bool check = false, quiet = false;
};

int check_file(const CookOptions& options)
{
    if (!options.out.empty() || !(options.options == MeshOptions{}))
        usage("cook: --check looks at a cooked file and writes none");
    const CookedSize size = check_cooked(options.mesh);
    if (!options.quiet)
        std::cout << fmt::format("{}: whole: {} chunk{}, {:.1f} MB\n", printable(options.mesh), size.chunks,
                                 size.chunks == 1 ? "" : "s", double(size.bytes) / 1e6);
    return 0;
}

int cook(const CookOptions& options)
{
    if (options.check) return check_file(options);
    if (options.out.empty()) usage("cook: --out FILE.cooked is needed");
    if (!is_cooked(options.out))
        usage(fmt::format("cook: --out {}: the name must end in .cooked, by which such files are known", options.out));
    check_files({{"--out", options.out}}, {options.mesh});
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
    const Mesh mesh = load_mesh(options.mesh, options.options);
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
    sub.add_option("mesh", options->mesh, "mesh file (OBJ, STL, PLY, OFF, glTF; '-': standard input)")
        .required()
        .type_name("FILE");
    sub.add_option("-o,--out", options->out, "cooked file to write").type_name("FILE.cooked");
    sub.add_option("--scale", options->options.scale, "metres per unit of the file (default 1)").type_name("S");
    sub.add_flag("--centre", options->options.centre, "move the middle of its box to the origin");
    sub.add_flag("--check", options->check, "read all of a cooked file instead, and check every box in it");
    sub.add_flag("--quiet", options->quiet, "print nothing but errors");
    sub.footer("Examples:\n"
               "  oncollide cook terrain.ply -o terrain.cooked\n"
               "  oncollide check terrain.cooked car.obj --max-error 0.01\n"
               "  oncollide cook --check terrain.cooked\n"
               "Scene files name a cooked file as any mesh file. Results are those of the mesh that was cooked. See "
               "docs/cooked.md.");
    sub.action([options] { return cook(*options); });
}

} // namespace oncollide::tools
