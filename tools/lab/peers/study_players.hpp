#pragma once
#include "study/peers.hpp"

namespace oncollide::tools {

/// All libraries that can play a study. By default only libraries play that keep a tree of both meshes: Embree and CGAL
/// process a whole mesh per query.
std::vector<PeerKind> study_peers();

} // namespace oncollide::tools
