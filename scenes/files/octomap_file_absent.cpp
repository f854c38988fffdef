// Replaces the functions that need OctoMap in builds without it.
#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide {
namespace {

[[noreturn]] void refuse(const std::string& name)
{
    throw Error(ErrorKind::usage, name + ": this is a build without OctoMap (ONCOLLIDE_OCTOMAP=OFF)");
}

} // namespace

OccupancyMap load_octomap(const std::filesystem::path& path, const MapOptions&)
{
    refuse(path.string());
}

void save_octomap(const OccupancyMap&, const std::filesystem::path& path)
{
    refuse(path.string());
}

} // namespace oncollide
