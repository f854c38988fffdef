#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/league.h>

namespace oncollide::tools {

/// Loads an adapter; it stays loaded. Throws Error{no_input} if the file is none, Error{bad_data} for another version
/// of the interface.
std::vector<const league_library*> open_adapter(const std::filesystem::path& file);

/// Loads the adapter in a process of its own, and throws Error{bad_data} if it crashes there, or takes 20 s. Cost: a
/// fork; call it before other threads run.
void try_to_open(const std::filesystem::path& file);

/// The adapters beside this program, or in ../lib/oncollide-league.
std::vector<std::filesystem::path> known_adapters();

} // namespace oncollide::tools
