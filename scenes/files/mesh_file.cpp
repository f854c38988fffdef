#include <oncollide/scenes/files/geometry_file.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/files/converted_file.hpp>
#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

namespace {

struct MeshFormat {
    const char* extension;
    RawMesh (*read)(const MeshSource&);
    /// Reads a file of at most that size in pieces; null: the file must be in memory as a whole.
    RawMesh (*read_file)(const std::filesystem::path&, std::uintmax_t) = nullptr;
};
constexpr MeshFormat mesh_formats[] = {{"obj", read_obj},     {"stl", read_stl, read_stl_file},
                                       {"ply", read_ply},     {"off", read_off},
                                       {"gltf", read_gltf},   {"glb", read_gltf},
                                       {"dae", read_collada}, {"3mf", read_3mf}};

/// Standard input has no extension; its first bytes decide.
std::string extension_of(std::string_view bytes)
{
    if (bytes.starts_with("glTF")) return ".glb";
    if (bytes.starts_with("PK\3\4")) return ".3mf";
    if (is_binary_stl(bytes)) return ".stl";
    bytes = without_byte_order_mark(bytes);
    bytes.remove_prefix(std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size()));
    if (bytes.starts_with('{')) return ".gltf";
    if (bytes.starts_with('<')) return ".dae";
    if (bytes.starts_with("ply")) return ".ply";
    if (bytes.starts_with("solid")) return ".stl";
    return bytes.substr(0, bytes.find_first_of(" \t\r\n")).ends_with("OFF") ? ".off" : ".obj";
}

/// Null: unknown.
const MeshFormat* format_of(std::string_view extension)
{
    for (const MeshFormat& format : mesh_formats)
        if (extension == std::string(".") + format.extension) return &format;
    return nullptr;
}

RawMesh read_raw(const std::filesystem::path& path, const std::string& name)
{
    if (is_converted_file(path)) return read_gltf({name, converted_file(path)});
    constexpr std::uintmax_t most = std::uintmax_t{2} << 30; // bytes
    const std::string extension = lower_extension(path);
    const MeshFormat* format = format_of(extension);
    if (format && format->read_file) return format->read_file(path, most);
    const FileBytes bytes = read_large_file(path, most);
    if (path == "-") format = format_of(extension_of(bytes));
    if (!format)
        throw Error(ErrorKind::bad_data, fmt::format("{}: unknown kind of mesh file '{}'; known are {}, and cooked",
                                                     name, extension, fmt::join(mesh_extensions(), ", ")));
    return format->read({name, bytes});
}

void check(const std::string& name, const MeshOptions& options)
{
    if (!(options.scale > 0) || !std::isfinite(options.scale))
        throw Error(ErrorKind::usage,
                    fmt::format("{}: the scale is {}; it must be finite and above 0", name, options.scale));
    if (!(options.fit_diagonal >= 0) || !std::isfinite(options.fit_diagonal))
        throw Error(ErrorKind::usage, fmt::format("{}: the diagonal to fit is {}; it must be finite and not below 0",
                                                  name, options.fit_diagonal));
}

} // namespace

Mesh load_mesh(const std::filesystem::path& path, const MeshOptions& options)
{
    const std::string name = path == "-" ? "standard input" : path.string();
    check(name, options);
    Mesh mesh;
    if (is_cooked(path)) {
        mesh = CookedMesh(path).whole();
    } else {
        RawMesh raw = read_raw(path, name);
        if (raw.triangles.empty())
            throw Error(ErrorKind::bad_data, fmt::format("{}: the file holds no triangle", name));
        mesh = make_mesh(name, std::move(raw.vertices), std::move(raw.triangles));
    }
    double scale = options.scale;
    if (options.fit_diagonal > 0) {
        if (!(mesh.bounds.diagonal() > 0))
            throw Error(ErrorKind::bad_data,
                        fmt::format("{}: all vertices are at one point, so no scale fits the diagonal", name));
        scale = options.fit_diagonal / mesh.bounds.diagonal();
    }
    const Eigen::Vector3d origin = options.centre ? mesh.bounds.centre() : Eigen::Vector3d::Zero();
    if (scale == 1 && !options.centre) return mesh;
    return transformed(name, std::move(mesh), scale, origin);
}

std::vector<std::string> mesh_extensions()
{
    std::vector<std::string> extensions = converted_extensions();
    std::ranges::transform(mesh_formats, std::inserter(extensions, extensions.begin()), &MeshFormat::extension);
    return extensions;
}

} // namespace oncollide
