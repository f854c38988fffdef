#pragma once
#include <oncollide/pipeline/pipeline.hpp>
#include <oncollide/pipeline/report.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

/// Moves the scene's bodies and steps the pipeline for `frames` frames, adding each to `report`; shows progress on
/// standard error when that is a terminal and not `quiet`.
///
/// Ctrl-C or SIGTERM ends it after the frame in hand: the report is marked interrupted and the answer is false. A
/// second one ends the program at once.
bool play(Scene& scene, Pipeline& pipeline, Report& report, int frames, bool quiet);

/// Exit code of a run that was interrupted, as shells have it for Ctrl-C.
inline constexpr int interrupted_code = 130;

} // namespace oncollide::tools
