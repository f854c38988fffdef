#pragma once
#include "clash/report.hpp"
#include "render/painter_process.hpp"

namespace oncollide::tools {

/// Draws each of the first `most` clashes that are new or the same: the contact on the left, both parts as a whole on
/// the right. Both parts are transparent, their common part is red, and the camera sees it from its widest side.
/// Pictures that OpenGL cannot draw are missing, and the note gives the reason.
ClashPictures draw_clashes(const ClashReport& report, PainterProcess& painter, std::size_t most, bool quiet);

} // namespace oncollide::tools
