#include "cli/play.hpp"

#include <chrono>
#include <csignal>
#include <iostream>
#include <unistd.h>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide::tools {
namespace {

volatile std::sig_atomic_t stop = 0;

void listen(int signal)
{
    struct sigaction old {};
    sigaction(signal, nullptr, &old);
    if (old.sa_handler == SIG_IGN) return; // nohup and background jobs: the parent does not want us to end
    struct sigaction action {};
    action.sa_handler = [](int) { stop = 1; };
    action.sa_flags = int(SA_RESETHAND) | SA_RESTART;
    sigaction(signal, &action, nullptr);
}

/// One line on the terminal that is drawn over itself, ten times a second at most.
class FrameProgress {
public:
    FrameProgress(int total, bool quiet) : frames_(total), on_(!quiet && ::isatty(STDERR_FILENO)) {}
    ~FrameProgress()
    {
        if (shown_) std::cerr << "\r\033[K" << std::flush;
    }

    void done(int count)
    {
        if (!on_) return;
        const Clock::time_point now = Clock::now();
        if (now - last_ < std::chrono::milliseconds(100)) return;
        last_ = now;
        const double rate = count / std::chrono::duration<double>(now - start_).count();
        std::cerr << fmt::format("\r\033[Kframe {}/{}  {:.1f} frames/s  {:.0f} s left", count, frames_, rate,
                                 (frames_ - count) / rate)
                  << std::flush;
        shown_ = true;
    }

private:
    using Clock = std::chrono::steady_clock;
    int frames_;
    bool on_, shown_ = false;
    Clock::time_point start_ = Clock::now(), last_ = start_;
};

} // namespace

int play(Scene& scene, Pipeline& pipeline, Report& report, int frames, bool quiet)
{
    listen(SIGINT);
    listen(SIGTERM);
    Mover mover;
    std::string note, lost;
    const auto say_note = [&] {
        const std::string now = pipeline.backend_note();
        if (now != note) std::cerr << "oncollide: note: " << now << "\n";
        note = now;
    };
    if (!quiet) say_note();
    int done = 0;
    {
        FrameProgress progress(frames, quiet);
        try {
            for (; done < frames && !stop; progress.done(++done)) {
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
