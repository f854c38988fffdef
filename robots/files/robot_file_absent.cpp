// Replaces the readers of URDF, SRDF and MJCF in builds without Expat.
#include <oncollide/robots/robot.hpp>

namespace oncollide {

RobotDescription load_robot(const std::filesystem::path& file, const RobotReading&)
{
    throw Error(
        ErrorKind::usage,
        file.string() +
            ": this is a build without the readers of URDF and MJCF; build on Linux with -DONCOLLIDE_XML=ON (Debian: "
            "libexpat1-dev, libzip-dev)");
}

} // namespace oncollide
