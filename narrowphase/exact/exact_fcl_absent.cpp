// Stands for exact_fcl.cpp in builds without FCL.
#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/exact/exact_fcl.hpp>

namespace oncollide {
namespace {

[[noreturn]] void refuse()
{
    throw Error(ErrorKind::usage, "this is a build without FCL (ONCOLLIDE_FCL=OFF)");
}

} // namespace

bool fcl_available()
{
    return false;
}

struct ExactFcl::Impl {};

ExactFcl::ExactFcl(const Scene&, double) {}
ExactFcl::~ExactFcl() = default;

void ExactFcl::prepare(GeometryId)
{
    refuse();
}

ExactFcl::Answer ExactFcl::answer(const Scene&, std::uint32_t, std::uint32_t) const
{
    refuse();
}

bool ExactFcl::both_meshes(const Scene&, std::uint32_t, std::uint32_t) const
{
    refuse();
}

bool ExactFcl::triangles_meet(const Scene&, std::uint32_t, std::uint32_t, std::span<const std::uint32_t>,
                              std::span<const std::uint32_t>, std::vector<Aabb>&) const
{
    refuse();
}

} // namespace oncollide
