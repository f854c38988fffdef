#pragma once
#include <string>

#include <nlohmann/json.hpp>

#include <oncollide/runs/pipeline.hpp>

namespace oncollide::tools {

/// How the results of a page were made: rows of a name and a value.
/// @param metres   metres per unit of the scene
/// @param results  results file of the frames; empty: they come from a run
nlohmann::json page_about(const Pipeline& pipeline, double metres, const std::string& results);

} // namespace oncollide::tools
