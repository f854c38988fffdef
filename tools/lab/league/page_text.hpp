#pragma once
#include <string_view>

// The page's source files in tools/lab/league/page/, embedded by the build.
namespace oncollide::tools::league_page {

extern const std::string_view league_html, league_css, league_js;

} // namespace oncollide::tools::league_page
