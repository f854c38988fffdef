// Replaces the readers of URDF and SRDF in builds without Expat.
#include <oncollide/robots/robot.hpp>

namespace oncollide {

RobotDescription load_robot(const std::filesystem::path& urdf, const RobotReading&)
{
    throw Error(ErrorKind::usage,
                urdf.string() + ": this is a build without the reader of URDF: install Debian's libexpat1-dev and "
                                "libzip-dev and configure with -DONCOLLIDE_XML=ON");
}

} // namespace oncollide
