#pragma once
#include <cstdint>

namespace oncollide {

/// What delimitation did at one level of its region hierarchy, level 0 being the whole scene.
struct DelimitationLevel {
    std::uint64_t regions = 0;          ///< regions looked at
    std::uint64_t regions_rejected = 0; ///< of these, regions in which nothing can collide
    std::uint64_t bodies_rejected = 0;  ///< bodies in them (a body that straddles regions counts in each)
    double volume_rejected = 0;         ///< share of the scene's volume that they cover, 0 to 1
};

} // namespace oncollide
