#include "view/three_js.hpp"

#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>

#include "cli/system.hpp"
#include "view/page_text.hpp"

namespace oncollide::tools {
namespace {

/// The text of a script, changed without changing its meaning so that it cannot end its HTML element.
std::string script_from(const std::filesystem::path& path)
{
    std::string text = read_file(path, 16'000'000);
    for (std::size_t at = 0; (at = text.find("</", at)) != std::string::npos; at += 3) text.replace(at, 2, "<\\/");
    return text;
}

} // namespace

ThreeJs read_three_js()
{
    namespace fs = std::filesystem;
    const char* variable = std::getenv("ONCOLLIDE_THREE");
#ifdef _WIN32 // its package brings three.js
    const fs::path usual = program_folder().parent_path() / "share" / "oncollide" / "three";
    constexpr const char* cure = "unpack the whole archive of oncollide, which holds three.js";
#else
    const fs::path usual = "/usr/share/javascript/three";
    constexpr const char* cure = "install Debian's package libjs-three";
#endif
    const fs::path folder = variable && *variable ? fs::path(variable) : usual;
    const fs::path library = folder / "three.min.js", controls = folder / "examples/js/controls/OrbitControls.js";
    std::error_code error;
    for (const fs::path& file : {library, controls})
        if (!fs::is_regular_file(file, error))
            throw Error(ErrorKind::no_input,
                        fmt::format("{}: not found; pages need three.js: {}, or set ONCOLLIDE_THREE to a folder that "
                                    "holds three.min.js (release 111) and examples/js/controls/OrbitControls.js",
                                    file.string(), cure));
    return {folder.string(), std::string(page::three_licence_txt) + script_from(library), script_from(controls)};
}

} // namespace oncollide::tools
