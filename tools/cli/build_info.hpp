#pragma once
#include <string>

namespace oncollide::tools {

/// How this program was compiled: "Release, GNU 12.2.0".
std::string build_text();
/// The compiler's flags.
std::string build_flags();
/// The parts of the library that this build has: "GL, FCL, OctoMap, ..."; and those that it lacks, "" for none.
std::string parts_built();
std::string parts_left_out();
/// The instruction sets of this processor that hot code is compiled for, and which is in use:
/// "baseline, avx2, avx512 (in use: avx512)".
std::string instruction_sets_text();
/// What --version prints, without a line end: the first line is "oncollide 0.1.0".
std::string version_text();

} // namespace oncollide::tools
