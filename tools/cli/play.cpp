#include "cli/play.hpp"

#include <iostream>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/printable.hpp>

#include "cli/progress.hpp"
#include "cli/system.hpp"

namespace oncollide::tools {
int play(Scene& scene, Pipeline& pipeline, Report& report, int frames, bool quiet)
{
    catch_interrupts();
    Mover mover;
    std::string note, lost;
    const auto say_note = [&] {
        const std::string now = pipeline.backend_note();
        if (now != note) std::cerr << "oncollide: note: " << printable(now) << "\n";
        note = now;
    };
    if (!quiet) say_note();
    int done = 0;
    {
        Progress progress("frame", std::size_t(frames), quiet);
        try {
            for (; done < frames && !interrupted(); ++done, progress.step()) {
                mover.move(scene, done);
                report.add(pipeline.step(scene));
            }
        } catch (const Error& error) {
            if (error.kind() != ErrorKind::no_gpu) throw;
            lost = error.what();
        }
    }
    if (lost.empty() && !quiet) say_note();
    if (done == frames) return 0;
    report.interrupted();
    std::cerr << fmt::format("oncollide: {} after {} of {} frames; results up to there follow\n",
                             lost.empty() ? "interrupted" : lost, done, frames);
    constexpr int interrupted_code = 130; // as shells have it for Ctrl-C
    return lost.empty() ? interrupted_code : int(ErrorKind::no_gpu);
}

} // namespace oncollide::tools
