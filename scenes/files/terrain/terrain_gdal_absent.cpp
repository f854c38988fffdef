// Replaces the reader that needs GDAL in builds without it.
#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/scenes/files/terrain/height_raster.hpp>

namespace oncollide {

HeightRaster read_with_gdal(const std::filesystem::path& path)
{
    check_readable(path);
    throw Error(
        ErrorKind::usage,
        path.string() +
            ": this is a build without GDAL, which reads such files; build on Linux with 'cmake --preset release "
            "-DONCOLLIDE_GDAL=ON' (Debian: libgdal-dev), or convert the file to PGM or NPY");
}

} // namespace oncollide
