#pragma once
#include "clash/report.hpp"

namespace oncollide::tools {

/// Writes a page in 3D: all parts as grey glass, and the new and active clashes as a list. A chosen clash shows its two
/// parts in colours and their common part in red. Needs no network.
/// @param most_bytes  size limit of the page. If it is reached, meshes are simplified, then common parts and clashes
///                    are left out, the least severe first; the page and the summary say so
/// Returns a summary of the file. Throws Error{no_input} without three.js, Error{usage} if the parts alone do not fit.
/// Cost: as overlap_surface() for each clash, on all threads of the settings.
std::string write_clash_view(const std::string& file, const ClashReport& report, std::size_t most_bytes);

/// The name of a clash's view on such a page, for links: "clash=ID".
inline std::string view_of(const Clash& clash)
{
    return "clash=" + clash.id;
}

} // namespace oncollide::tools
