#pragma once
#include "clash/report.hpp"

namespace oncollide::tools {

/// A picture of each of the first `most` clashes that are new or the same: left from near, right both parts as a whole.
/// Both parts are of glass, what they share is red, and the camera is where that is seen widest. Without OpenGL there
/// are none, and the note says why.
ClashPictures draw_clashes(const ClashReport& report, std::size_t most, bool quiet);

} // namespace oncollide::tools
