#pragma once
#include <cstddef>
#include <vector>

namespace oncollide::tools {

/// Steps of an articulated body of 15 links that walks past posts.
struct ArticulatedResult {
    std::size_t links = 0, triangles = 0, posts = 0, triangles_of_posts = 0;
    std::vector<double> us{};     ///< by step
    std::size_t contacts = 0;     ///< pairs that met on their ways
    std::size_t contradicted = 0; ///< of the sampled poses, that collide before the certified time
};

/// In each step, all links move at once, to the poses of the next instant of a walk, in a straight line and along the
/// shorter arc. Links that share a joint are excluded.
/// @param tolerance  of the time and, in metres, of the gap
/// @param samples    poses in each step at which exact tests check all pairs
ArticulatedResult walk_articulated_body(int steps, double tolerance, int samples);

} // namespace oncollide::tools
