// The scenes of the benchmark: one run of a detector each.
#pragma once
#include <filesystem>

#include "measure.hpp"

namespace dart::collision::oncollide_client::bench {

struct SceneRun {
    std::string scene, variant;
    std::function<Measures(const std::string& detector, const Limits& limits)> run;
};

/// All scenes; those of files only if the folder has them (contacts/ and meshes/paper/).
std::vector<SceneRun> all_scenes(const std::filesystem::path& data);

} // namespace dart::collision::oncollide_client::bench
