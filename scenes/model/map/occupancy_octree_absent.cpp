// Replaces the functions that need OctoMap in builds without it.
#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>

namespace oncollide {
namespace {

[[noreturn]] void refuse(const char* what)
{
    throw Error(ErrorKind::usage, std::string(what) + ": this is a build without OctoMap (ONCOLLIDE_OCTOMAP=OFF)");
}

} // namespace

std::shared_ptr<octomap::OcTree> make_octree(const OccupancyMap&)
{
    refuse("make_octree");
}

void OccupancyMap::insert_scan(std::span<const Eigen::Vector3d>, const Eigen::Vector3d&, double)
{
    refuse("insert_scan");
}

} // namespace oncollide
