#include "fcl/fcl_pair.hpp"

#include <filesystem>
#include <string_view>

#include <link.h>

#include <oncollide/base/files/paths.hpp>

namespace oncollide::tools {

std::string fcl_text()
{
    const std::string version = "FCL " ONCOLLIDE_FCL_VERSION " ";
    std::string path;
    dl_iterate_phdr(
        [](dl_phdr_info* info, std::size_t, void* out) {
            if (std::string_view(info->dlpi_name).find("/libfcl.so") != std::string_view::npos)
                *static_cast<std::string*>(out) = info->dlpi_name;
            return 0;
        },
        &path);
    if (path.empty() || path.starts_with("/usr/") || path.starts_with("/lib/")) return version + "as installed";
    return version + "from " + path_from(".", std::filesystem::path(path).parent_path()).string();
}

} // namespace oncollide::tools
