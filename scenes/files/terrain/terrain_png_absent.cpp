// Replaces the reader that needs libpng in builds without it.
#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/terrain/height_raster.hpp>

namespace oncollide {

HeightRaster read_grey_png(const std::string& name, std::string_view)
{
    throw Error(ErrorKind::usage,
                name + ": this is a build without libpng (ONCOLLIDE_PNG=OFF); convert the file to PGM or NPY");
}

} // namespace oncollide
