// How the reference solver plays a scene of 'bench contacts'.
#pragma once
#include "bench/contacts/contact_scenes.hpp"

namespace oncollide::tools {

/// The run of a scene, or its bodies as they are at first if nothing plays it.
struct PlayedScene {
    std::vector<Poses> poses; ///< in each timed step; empty if nothing plays it
    double step_ms = 0;       ///< of the solver and the World together, median of the timed steps
    double creep = 0;         ///< greatest displacement of a body in the timed steps, over their time, m/s
    double aside = 0;         ///< greatest speed of the first moving body across the speed that it began with, m/s
    double speed = 0;         ///< its speed along that, as a share
    double depth = 0;         ///< greatest depth in the timed steps, m
    double lead = 0;          ///< of the first moving body: way along z per turn around it, m
    double turns = 0;
    std::size_t pairs = 0, regions = 0, points = 0, most_points = 0; ///< last step; most_points: of a pair
    bool complete = true;
    std::uint64_t hash = 0; ///< of the last step's manifolds
};

/// @param steps  at most; 0: the bodies stay where they are
PlayedScene play(const ContactScene& scene, int steps, int threads);

} // namespace oncollide::tools
