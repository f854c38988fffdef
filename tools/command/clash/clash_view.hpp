#pragma once
#include "clash/report.hpp"

namespace oncollide::tools {

/// Writes all parts as a page in 3D (view/view_page.hpp), in which body i is part i. Decides the pairs again.
/// @param most_bytes  size limit of the page
/// Returns a summary of the file. Throws Error{no_input} without three.js.
std::string write_clash_view(const std::string& file, const ClashReport& report, std::size_t most_bytes);

} // namespace oncollide::tools
