#pragma once
#include "clash/report.hpp"

namespace oncollide::tools {

/// Writes new and active clashes as BCF 2.1 (buildingSMART's exchange format for issues): one topic per clash, with a
/// viewpoint, the two parts as its components, and its picture if there is one. A clash has the same topic in every
/// run.
void write_bcf(OutputFile& file, const ClashReport& report, const ClashPictures& pictures);

} // namespace oncollide::tools
