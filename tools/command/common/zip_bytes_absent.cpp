// Replaces zip_bytes.cpp in builds without libzip.
#include <oncollide/base/error.hpp>

#include "common/zip_bytes.hpp"

namespace oncollide::tools {

std::string zip_version()
{
    return {};
}

void check_zip(const std::string& option)
{
    throw Error(ErrorKind::usage, option + ": this is a build without libzip: install Debian's libexpat1-dev and "
                                           "libzip-dev and configure with -DONCOLLIDE_XML=ON");
}

std::string zip_bytes(const std::vector<std::pair<std::string, std::string>>&, std::int64_t)
{
    check_zip("BCF");
    return {};
}

} // namespace oncollide::tools
