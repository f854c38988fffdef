#pragma once
#include "clash/report.hpp"

namespace oncollide::tools {

enum class BcfVersion : std::uint8_t { v2_1, v3_0 };

/// Writes new and active clashes as BCF (buildingSMART's exchange format for issues): one topic per clash, with a
/// viewpoint, the two parts as its components, by their IfcGuid if they have one, and its picture if there is one. A
/// clash has the same topic in every run.
void write_bcf(OutputFile& file, const ClashReport& report, const ClashPictures& pictures, BcfVersion version);

} // namespace oncollide::tools
