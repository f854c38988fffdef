// Bodies that slide down a hill, for 'bench avalanche'.
#pragma once
#include <memory>

#include "bench/contacts/contact_scenes.hpp"

namespace oncollide::tools {

struct AvalancheScene {
    std::shared_ptr<const Geometry> hill; ///< a terrain
    std::vector<ContactBody> bodies;      ///< they move
};

/// @param bodies  that are shapes, of all kinds; the hill has about 100 triangles for each body
AvalancheScene make_avalanche(int bodies, int meshes, std::uint64_t seed);

/// The height of the hill at a place; above all its heights outside of it, where no body should come.
double height_at(const Terrain& hill, double x, double y);

} // namespace oncollide::tools
