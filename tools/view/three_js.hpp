#pragma once
#include <string>

namespace oncollide::tools {

/// The library that pages draw with.
struct ThreeJs {
    std::string library, controls; ///< JavaScript, safe between <script> and </script>
};

/// Reads three.js where Debian's libjs-three puts it, or from the folder that $ONCOLLIDE_THREE names. Throws
/// Error{no_input} that names the package when it is not there.
ThreeJs read_three_js();

} // namespace oncollide::tools
