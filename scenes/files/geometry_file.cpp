#include <oncollide/scenes/files/geometry_file.hpp>

#include <algorithm>
#include <memory>

#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/text/file_warning.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>

namespace oncollide {

FileKind kind_of_file(const std::filesystem::path& path)
{
    const std::string extension = lower_extension(path);
    if (extension == ".cooked") return FileKind::cooked;
    if (extension == ".bt" || extension == ".ot") return FileKind::map;
    const bool heights = !extension.empty() && std::ranges::count(terrain_extensions(), extension.substr(1)) > 0;
    return heights ? FileKind::terrain : FileKind::mesh;
}

void on_file_warning(FileWarningWatcher watch)
{
    watch_file_warnings(watch);
}

namespace {

GeometryData data_of(const std::filesystem::path& path)
{
    FileKind kind = kind_of_file(path);
    if (kind == FileKind::cooked) {
        const CookedKind cooked = cooked_kind(path);
        if (cooked == CookedKind::mesh) return std::make_shared<const CookedMesh>(path);
        kind = cooked == CookedKind::terrain ? FileKind::terrain : FileKind::map;
    }
    if (kind == FileKind::terrain) return load_terrain(path);
    if (kind == FileKind::map) return load_octomap(path);
    return load_mesh(path);
}

} // namespace

std::shared_ptr<Geometry> load_geometry(const std::filesystem::path& path)
{
    return std::make_shared<Geometry>(Geometry{path.string(), data_of(path), {}});
}

} // namespace oncollide
