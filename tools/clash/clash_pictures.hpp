#pragma once
#include "clash/report.hpp"

namespace oncollide::tools {

/// Draws each of the first `most` clashes that are new or the same: the contact on the left, both parts as a whole on
/// the right. Both parts are transparent, their common part is red, and the camera sees it from its widest side.
/// Without OpenGL there are no pictures, and the note gives the reason.
ClashPictures draw_clashes(const ClashReport& report, std::size_t most, bool quiet);

} // namespace oncollide::tools
