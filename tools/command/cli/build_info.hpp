#pragma once
#include <string>

namespace oncollide::tools {

/// Build type and compiler: "Release, GNU 12.2.0".
std::string build_text();
/// The compiler's flags.
std::string build_flags();
/// The optional parts of the library that this build has and lacks: "OpenGL, FCL, OctoMap; without GDAL, MPI".
std::string parts_text();
/// Whether this build has backends that run on a GPU.
bool has_gpu_backends();
/// The instruction sets of this processor for which hot code is compiled, and the one in use:
/// "baseline, avx2, avx512 (in use: avx512)".
std::string instruction_sets_text();
/// The text of --version, without a final line end. The first line is the program's name and "0.1.0".
std::string version_text();

} // namespace oncollide::tools
