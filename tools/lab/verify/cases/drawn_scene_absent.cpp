// Replaces drawn_scene.cpp in builds without OctoMap.
#include "verify/cases/drawn_scene.hpp"

#include <oncollide/base/error.hpp>

namespace oncollide::tools {

namespace {

[[noreturn]] void refuse()
{
    throw Error(ErrorKind::usage,
                "drawn scenes have maps of OctoMap, and this is a build without it (ONCOLLIDE_OCTOMAP=OFF)");
}

} // namespace

DrawnScene draw_scene(std::uint64_t)
{
    refuse();
}

DrawnSweep draw_sweep(std::uint64_t)
{
    refuse();
}

} // namespace oncollide::tools
