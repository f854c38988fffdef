#pragma once
#include <oncollide/pipeline/pipeline.hpp>
#include <oncollide/pipeline/report.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

/// Moves the scene's bodies and steps the pipeline for `frames` frames, adding each to `report`; shows progress on
/// standard error when that is a terminal and not `quiet`.
///
/// Returns the exit code of the run. Ctrl-C or SIGTERM ends it after the frame in hand; a second one ends the program
/// at once. A GPU that was requested by name and is lost ends it too. Either way the report is marked interrupted and
/// is worth writing.
int play(Scene& scene, Pipeline& pipeline, Report& report, int frames, bool quiet);

} // namespace oncollide::tools
