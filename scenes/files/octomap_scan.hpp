#pragma once
#include <string>
#include <string_view>

namespace oncollide {

struct OctomapScan {
    double resolution;
    std::size_t nodes_begin; ///< the byte at which the nodes start
};

/// Walks the bytes of a `.bt` or `.ot` file as OctoMap's reader would and throws Error{bad_data}, with `name` in front,
/// unless they are one whole tree: OctoMap itself reads on beyond the end of a truncated file and follows any depth.
/// Private to scenes.
OctomapScan scan_octomap(const std::string& name, std::string_view bytes, bool binary);

} // namespace oncollide
