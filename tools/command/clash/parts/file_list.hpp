#pragma once
#include <string>
#include <vector>

namespace oncollide::tools {

/// The files that `inputs` name: files, and below folders all mesh files and all files of CAD programs, readable or
/// not, sorted within a folder. Throws Error{no_input} for a path that does not exist and for a folder without such
/// files, and Error{usage} for a file that is named twice.
/// @param warnings  gets a line for each folder that names its other files: no part may be missing in silence
std::vector<std::string> files_of(const std::vector<std::string>& inputs, std::vector<std::string>* warnings = nullptr);

/// Throws Error{no_input} for a file of a CAD program that no reader here reads.
void check_format(const std::string& file);

} // namespace oncollide::tools
