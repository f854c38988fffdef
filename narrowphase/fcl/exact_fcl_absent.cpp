// Replaces exact_fcl.cpp in builds without FCL.
#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/fcl/exact_fcl.hpp>

namespace oncollide {
namespace {

[[noreturn]] void refuse_without_fcl()
{
    throw Error(ErrorKind::usage, "this is a build without FCL (ONCOLLIDE_FCL=OFF)");
}

} // namespace

bool fcl_available()
{
    return false;
}

class FclModel {};

std::shared_ptr<const FclModel> make_fcl_model(const GeometryData&)
{
    refuse_without_fcl();
}

bool fcl_collides(const FclModel&, const Eigen::Isometry3d&, const FclModel&, const Eigen::Isometry3d&)
{
    refuse_without_fcl();
}

} // namespace oncollide
