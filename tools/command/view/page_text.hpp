#pragma once
#include <string_view>

// The page's source files in tools/command/view/page/, embedded by the build.
namespace oncollide::tools::page {

extern const std::string_view page_html, style_css, three_licence_txt, columns_js, data_js, bodies_js, sprites_js,
    overlay_js, trees_js, panel_js, main_js;

} // namespace oncollide::tools::page
