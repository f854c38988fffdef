// Replaces fcl_pair.cpp and fcl_world.cpp in builds without FCL.
#include "fcl/fcl_pair.hpp"
#include "fcl/fcl_world.hpp"

#include <oncollide/base/error.hpp>

namespace oncollide::tools {
namespace {

[[noreturn]] void refuse_without_fcl()
{
    throw Error(ErrorKind::usage, "this needs FCL, which this build lacks (ONCOLLIDE_FCL=OFF)");
}

} // namespace

std::string fcl_text()
{
    return "without FCL";
}

FclGeometry make_fcl_geometry(const GeometryData&, FclNodes, std::shared_ptr<const octomap::OcTree>)
{
    refuse_without_fcl();
}
double fcl_time_of_contact(const FclBody&, const Eigen::Isometry3d&, const FclBody&, const Eigen::Isometry3d&, FclSweep,
                           double)
{
    refuse_without_fcl();
}

FclPair::FclPair(const Mesh&, const Mesh&, FclNodes)
{
    refuse_without_fcl();
}
std::size_t FclPair::contacts(const Eigen::Isometry3d&, std::size_t) const
{
    refuse_without_fcl();
}
double FclPair::distance(const Eigen::Isometry3d&) const
{
    refuse_without_fcl();
}

struct FclWorld::Impl {};
FclWorld::Octrees FclWorld::octrees_of(const Scene&)
{
    refuse_without_fcl();
}
FclWorld::FclWorld(const Scene&, const Octrees&)
{
    refuse_without_fcl();
}
FclWorld::~FclWorld() = default;
FclFrame FclWorld::step(bool)
{
    refuse_without_fcl();
}
FclWorld::ModelBytes FclWorld::model_bytes() const
{
    refuse_without_fcl();
}

} // namespace oncollide::tools
