#pragma once
#include <string>

namespace oncollide::tools {

struct SelfCheckOptions {
    std::string input;                         ///< a file, or a folder, whose mesh files are all checked
    std::string json, contacts, picture, view; ///< files to write; empty: none
    int view_limit = 40;                       ///< MB
    bool quiet = false;
};

/// Whether meshes meet themselves, and where. Returns the exit code: 1 if one does.
int check_self(const SelfCheckOptions& options);

} // namespace oncollide::tools
