#pragma once
#include <string>
#include <vector>

#include "cli/arguments.hpp"
#include "study/peers.hpp"

namespace oncollide::tools {

/// Adds the command `study`.
/// @param called  how one types it: "oncollide accuracy study"
/// @param peers   the libraries of --peers
void add_study(Arguments parent, const std::string& called, std::vector<PeerKind> peers);

} // namespace oncollide::tools
