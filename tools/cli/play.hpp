#pragma once
#include <span>

#include <oncollide/pipeline/pipeline.hpp>
#include <oncollide/pipeline/report.hpp>
#include <oncollide/scenes/scene.hpp>

#include "cli/outputs.hpp"

namespace oncollide::tools {

/// Who keeps each frame as it is done, besides the report.
class FrameSink {
public:
    virtual ~FrameSink() = default;
    virtual void add(const FrameView& frame) = 0;
    /// Nothing follows. A frame may still be under way, and poses be changing.
    virtual void close() = 0;
};

/// Moves the scene's bodies and steps the pipeline for frames `first` to `frames`, adding each to `sinks` and `report`;
/// shows progress on standard error when that is a terminal and not quiet. The sinks are the caller's to close, but
/// where the program ends here.
///
/// Returns the exit code of the run. Ctrl-C or SIGTERM ends it after the frame in hand; if that takes over half a
/// second more, the outputs are written without it and the program ends here. A second one ends the program at once. A
/// GPU that was requested by name and is lost, or a body that leaves the world, ends the run too, with the code of that
/// error. Whenever it ends early, the report is marked interrupted and is worth writing.
int play(Scene& scene, Pipeline& pipeline, Report& report, int frames, const OutputOptions& outputs, int first = 0,
         std::span<FrameSink* const> sinks = {});

/// Says what went wrong with cooked files, a line each on standard error. Returns the exit code: 0 if nothing did.
int say_file_faults(const World& world);

} // namespace oncollide::tools
