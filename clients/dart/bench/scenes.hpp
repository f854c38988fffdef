// The scenes of the benchmark: one run of a detector each.
#pragma once
#include <filesystem>

#include "measure.hpp"
#include "pictures.hpp"

namespace dart::collision::oncollide_client::bench {

struct SceneRun {
    std::string scene, variant;
    /// Adds the end state to the view.
    std::function<Measures(const std::string& detector, const Limits& limits, View& view)> run;
};

/// All scenes. The nut needs data/contacts/, and the cows need data/meshes/paper/.
std::vector<SceneRun> all_scenes(const std::filesystem::path& data);

} // namespace dart::collision::oncollide_client::bench
