#pragma once
#include <span>

#include <oncollide/runs/pipeline.hpp>
#include <oncollide/runs/report.hpp>
#include <oncollide/scenes/scene.hpp>

#include "cli/outputs.hpp"

namespace oncollide::tools {

/// Stores each completed frame, in addition to the report.
class FrameSink {
public:
    virtual ~FrameSink() = default;
    virtual void add(const FrameView& frame) = 0;
    /// No frame follows. A frame may still be in progress, and poses may be changing.
    virtual void close() = 0;
};

/// Moves the scene's bodies and steps the pipeline for frames `first` to `frames`, adding each frame to `sinks` and
/// `report`. Shows progress on standard error if it is a terminal and `quiet` is off. The caller closes the sinks,
/// unless the program ends here.
///
/// Returns the exit code of the run. Ctrl-C or SIGTERM ends the run after the current frame; if that takes more than
/// half a second, the outputs are written without that frame and the program ends here. A second signal ends the
/// program at once. The loss of a GPU that was requested by name, or a body that leaves the world, also ends the run,
/// with the exit code of that error. After an early end the report is marked interrupted and can be written.
int play(Scene& scene, Pipeline& pipeline, Report& report, int frames, const OutputOptions& outputs, int first = 0,
         std::span<FrameSink* const> sinks = {});

/// Prints the faults of cooked files, one per line, to standard error. Returns the exit code; 0 without faults.
int say_file_faults(const World& world);

} // namespace oncollide::tools
