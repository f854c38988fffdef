#pragma once
#include <string_view>

// The page's source files in tools/command/clash/view/page/, embedded by the build.
namespace oncollide::tools::clash_page {

extern const std::string_view clashes_html, clashes_css, model_js, list_js, clashes_js;

} // namespace oncollide::tools::clash_page
