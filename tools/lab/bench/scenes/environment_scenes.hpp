#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/scenes/scene.hpp>

#include "bench/common/benchmark.hpp"

namespace oncollide::tools {

/// The available environments: generated ones, files in the data folder, and single shapes by kind.
const std::vector<std::string>& environment_names();

/// The environments, and the bodies in them.
struct EnvironmentChoice {
    std::string environments = "building,hills,hills-mesh", bodies_of = "meshes,shapes";
    int bodies;
    int cells = 500; ///< along a side of generated terrains
    std::uint64_t seed = 1;
    std::string data{};

    /// Description of the work; must be equal for all parts of it.
    std::string work() const;
};

/// Adds the options of `in`; its values are their defaults.
void add_environment_choice(BenchmarkCommand& sub, EnvironmentChoice& in, int most_bodies);

/// One large static body, and many small ones on and just above its surface, which drift slightly in every frame.
struct EnvironmentScene {
    std::string environment = "building";
    /// "meshes" of 6,000 to 13,000 triangles; "shapes": spheres, boxes and capsules; "all-shapes", of all bounded
    /// kinds; or "both", meshes and shapes
    std::string bodies_of = "meshes";
    int bodies = 500, frames = 10;
    int cells = 500; ///< along a side of generated terrains
    std::uint64_t seed = 1;
    std::filesystem::path data; ///< folder of the files
};

/// Throws Error{usage} for an unknown name and for a file without a data folder, Error{no_input} for a missing file.
void check(const EnvironmentScene& which);
/// One scene per environment and kind of bodies. Throws as check().
std::vector<EnvironmentScene> scenes_of(const EnvironmentChoice& choice, int frames);
/// Calls check() first.
Scene make_environment_scene(const EnvironmentScene& which);

} // namespace oncollide::tools
