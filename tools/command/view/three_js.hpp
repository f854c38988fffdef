#pragma once
#include <string>

namespace oncollide::tools {

/// The library that draws on pages.
struct ThreeJs {
    std::string folder;            ///< where it was found
    std::string library, controls; ///< JavaScript, safe between <script> and </script>;
                                   ///< the library begins with its licence
};

/// Reads three.js from the folder of Debian's libjs-three, or from the folder that $ONCOLLIDE_THREE names. Throws
/// Error{no_input}, naming the package, if it is missing.
ThreeJs read_three_js();

} // namespace oncollide::tools
