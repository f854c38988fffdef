#include "play/play.hpp"

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <system_error>
#include <thread>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

#include "cli/log.hpp"
#include "cli/progress.hpp"
#include "cli/standard_output.hpp"
#include "cli/system.hpp"

namespace oncollide::tools {
namespace {

/// Ends the program if it is interrupted and the current frame does not end in time. A thread checks every 50 ms, and
/// writes the results of the completed frames. Without this thread, the program waits for the frame.
class Watchdog {
public:
    explicit Watchdog(std::function<void()> end) : end_(std::move(end))
    {
        try {
            thread_ = std::thread([this] { watch(); });
        } catch (const std::system_error&) { // usually out of memory
        }
    }
    ~Watchdog()
    {
        {
            const std::lock_guard lock(mutex_);
            over_ = true;
        }
        wake_.notify_all();
        if (thread_.joinable()) thread_.join();
    }
    /// Locked while the report changes. The watchdog never unlocks it.
    std::mutex& mutex() { return mutex_; }

private:
    void watch()
    {
        using namespace std::chrono_literals;
        std::unique_lock lock(mutex_);
        const auto over = [&] { return over_; };
        while (!interrupted())
            if (wake_.wait_for(lock, 50ms, over)) return;
        if (!wake_.wait_for(lock, 500ms, over)) end_();
    }

    std::function<void()> end_;
    std::mutex mutex_;
    std::condition_variable wake_;
    bool over_ = false;
    std::thread thread_;
};

/// How many frames were done, and where their results are.
std::string told(const OutputOptions& outputs, int done, int all)
{
    const std::string names = names_of(outputs);
    return fmt::format("after {} of {} frames; their results {}", done, all,
                       names.empty() ? "follow" : "are in " + names);
}

std::string describe(const FrameView& frame)
{
    std::array<std::size_t, 4> counts{};
    for (const PairResult& pair : frame.pairs) ++counts[std::size_t(pair.verdict)];
    return fmt::format("frame {}: {:.3f} ms; {} colliding, {} within, {} undecided, {} separate", frame.frame, frame.ms,
                       counts[std::size_t(Verdict::colliding)], counts[std::size_t(Verdict::within)],
                       counts[std::size_t(Verdict::undecided)], counts[std::size_t(Verdict::separate)]);
}

[[noreturn]] void end_in_a_frame(Report& report, std::span<FrameSink* const> sinks, const OutputOptions& outputs,
                                 int done, int all)
{
    int code = interrupted_code;
    try {
        report.interrupted();
        log(LogLevel::error, "interrupted " + told(outputs, done, all));
        write_outputs(report, outputs);
        for (FrameSink* sink : sinks) sink->close();
        check_stdout();
    } catch (const Error& error) {
        log(LogLevel::error, error.what());
        code = int(error.kind());
    }
    std::_Exit(code); // no clean-up: the frame is still being computed
}

} // namespace

int say_file_faults(const World& world)
{
    const std::vector<std::string> faults = world.inspect().file_faults;
    for (const std::string& fault : faults) log(LogLevel::error, fault);
    return faults.empty() ? 0 : int(ErrorKind::bad_data);
}

int play(Scene& scene, Pipeline& pipeline, Report& report, int frames, const OutputOptions& outputs, int first,
         std::span<FrameSink* const> sinks)
{
    catch_interrupts();
    Mover mover;
    std::string note, why;
    int done = first, code = interrupted_code;
    const auto say_note = [&] {
        const std::string now = pipeline.inspect().backend_note;
        if (now != note) log(LogLevel::note, now);
        note = now;
    };
    if (!outputs.quiet) say_note();
    log(LogLevel::info, fmt::format("running {} frames on {}", frames - first, pipeline.inspect().backend));
    {
        Progress progress("frame", std::size_t(frames - first), outputs.quiet);
        Watchdog watchdog([&] { end_in_a_frame(report, sinks, outputs, done, frames); });
        try {
            while (done < frames && !interrupted()) {
                mover.move(scene, done);
                const FrameView frame = pipeline.step(scene);
                {
                    const std::lock_guard lock(watchdog.mutex());
                    for (FrameSink* sink : sinks) sink->add(frame);
                    report.add(frame);
                    if (logged(LogLevel::debug)) log(LogLevel::debug, describe(frame));
                    ++done;
                }
                progress.step();
            }
        } catch (const Error& error) {
            if (done == first || error.kind() == ErrorKind::cannot_write) throw;
            why = error.what(), code = int(error.kind());
        } catch (const std::bad_alloc&) {
            if (done == first) throw;
            why = "out of memory", code = int(ErrorKind::internal);
        }
    }
    if (why.empty() && !outputs.quiet) say_note();
    if (done == frames) {
        release_interrupts();
        return say_file_faults(pipeline.world());
    }
    report.interrupted();
    say_file_faults(pipeline.world());
    log(LogLevel::error,
        fmt::format("{} {}", why.empty() ? "interrupted" : why + "; ended", told(outputs, done, frames)));
    return code;
}

} // namespace oncollide::tools
