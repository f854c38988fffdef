// Scenes of bodies that are shapes: piles, bodies on the ground, single pairs.
#pragma once
#include "bench/contacts/contact_scenes.hpp"

namespace oncollide::tools {

/// @param bodies  number of bodies of each, and of the pairs; 0: as the names say
std::vector<ContactEntry> shape_scenes(int bodies);

} // namespace oncollide::tools
