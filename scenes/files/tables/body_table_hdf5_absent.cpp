#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/file_bytes.hpp>
#include <oncollide/scenes/files/tables/body_table.hpp>

namespace oncollide {

void read_hdf5_bodies(BodyRows& rows, const std::filesystem::path& path, const std::string&)
{
    check_readable(path);
    throw Error(ErrorKind::usage, fmt::format("{}: this build cannot read HDF5; install Debian's libhdf5-dev and "
                                              "configure with -DONCOLLIDE_HDF5=ON, or write the table as CSV",
                                              rows.file()));
}

} // namespace oncollide
