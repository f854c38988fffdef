#include <oncollide/scenes/files/scene_file.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/scenes/files/assembly/raw_assembly.hpp>
#include <oncollide/scenes/files/converted_file.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide {

namespace {

static_assert(no_node_above == no_node);

struct AssemblyFormat {
    const char* extension;
    RawAssembly (*read)(const MeshSource&, const PartsReading&);
};
constexpr AssemblyFormat assembly_formats[] = {
    {".glb", read_gltf_parts}, {".gltf", read_gltf_parts}, {".dae", read_collada_parts}, {".3mf", read_3mf_parts}};

/// Null: another kind of file.
const AssemblyFormat* format_of(const std::filesystem::path& path)
{
    if (is_converted_file(path)) return &assembly_formats[0];
    const std::string extension = lower_extension(path);
    for (const AssemblyFormat& format : assembly_formats)
        if (extension == format.extension) return &format;
    return nullptr;
}

std::shared_ptr<const Geometry> shared_geometry(std::string name, Mesh mesh)
{
    return std::make_shared<const Geometry>(Geometry{std::move(name), std::move(mesh), {}});
}

Assembly load_parts(const AssemblyFormat& format, const std::filesystem::path& path, const AssemblyOptions& options)
{
    const std::string file = path.string();
    RawAssembly raw;
    const auto read = [&](std::string_view bytes) {
        raw = format.read({file, bytes}, {options.scale, options.threads, options.most_parts});
    };
    if (is_converted_file(path))
        read(converted_file(path));
    else
        read(read_large_file(path, std::uintmax_t(2) << 30));
    Assembly assembly;
    std::erase_if(raw.parts, [&](const RawPart& part) { return raw.meshes[part.mesh].triangles.empty(); });
    if (raw.parts.empty()) throw Error(ErrorKind::bad_data, fmt::format("{}: the file holds no triangle", file));
    std::vector<std::string> names(raw.meshes.size());
    for (const RawPart& part : raw.parts)
        if (names[part.mesh].empty()) names[part.mesh] = fmt::format("{}: {}", file, part.name);
    assembly.meshes.resize(raw.meshes.size());
    parallel_chunks(raw.meshes.size(), 1, options.threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            RawMesh& mesh = raw.meshes[i];
            if (mesh.triangles.empty()) continue;
            assembly.meshes[i] =
                shared_geometry(names[i], make_mesh(names[i], std::move(mesh.vertices), std::move(mesh.triangles)));
        }
    });
    for (RawPart& part : raw.parts)
        assembly.parts.push_back(
            {std::move(part.name), std::move(part.path), part.above, part.mesh, part.pose, std::move(part.extras)});
    return assembly;
}

} // namespace

bool is_assembly_file(const std::filesystem::path& path)
{
    return format_of(path) != nullptr;
}

Assembly load_assembly(const std::filesystem::path& path, const AssemblyOptions& options)
{
    const double scale = options.scale;
    if (!(scale > 0) || !std::isfinite(scale))
        throw Error(ErrorKind::usage,
                    fmt::format("{}: the scale is {}; it must be finite and above 0", path.string(), scale));
    if (const AssemblyFormat* const format = format_of(path)) return load_parts(*format, path, options);
    if (options.objects && lower_extension(path) == ".obj") return load_parts({".obj", read_obj_parts}, path, options);
    const std::string name = path == "-" ? "standard input" : path.stem().string();
    return {{shared_geometry(path.string(), load_mesh(path, {.scale = scale}))},
            {{name, name, no_node_above, 0, Eigen::Isometry3d::Identity()}}};
}

Scene load_assembly_scene(const std::filesystem::path& path, const AssemblyOptions& options)
{
    const Assembly assembly = load_assembly(path, options);
    Scene scene;
    scene.name = path.filename().string();
    std::vector<GeometryId> geometries(assembly.meshes.size());
    for (std::size_t i = 0; i < assembly.meshes.size(); ++i)
        if (const auto& geometry = assembly.meshes[i])
            geometries[i] = scene.add(fmt::format("{} #{}", geometry->name, i), geometry->data);
    std::map<std::string, int> numbers;
    for (const AssemblyPart& part : assembly.parts) {
        std::string name = part.name;
        while (scene.find(name)) name = fmt::format("{} ({})", part.name, ++numbers[part.name] + 1);
        scene.add_body({.name = name, .geometry = geometries[part.mesh], .pose = part.pose});
    }
    return scene;
}

} // namespace oncollide
