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
    throw Error(ErrorKind::usage,
                option + ": this is a build without libzip; build on Linux with -DONCOLLIDE_XML=ON (Debian: "
                         "libexpat1-dev, libzip-dev)");
}

std::string zip_bytes(const std::vector<std::pair<std::string, std::string>>&, std::int64_t)
{
    check_zip("BCF");
    return {};
}

} // namespace oncollide::tools
