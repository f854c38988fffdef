#include "play/play_ranks.hpp"

#include <algorithm>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <thread>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/runs/ranks/ranked_report.hpp>
#include <oncollide/runs/report_kept.hpp>

#include "cli/log.hpp"
#include "cli/progress.hpp"
#include "cli/standard_output.hpp"
#include "cli/system.hpp"

namespace oncollide::tools {
namespace {

namespace fs = std::filesystem;

/// Ends this process, and with it the job, if alive() is not called for `seconds`: another process hangs. Process 0
/// ends first, the others 5 s later.
class RankWatchdog {
public:
    RankWatchdog(int seconds, int rank) : limit_(seconds + (rank ? 5 : 0)), rank_(rank)
    {
        thread_ = std::thread([this] { watch(); });
    }
    ~RankWatchdog()
    {
        {
            const std::lock_guard lock(mutex_);
            over_ = true;
        }
        wake_.notify_all();
        thread_.join();
    }
    void alive(std::string phase)
    {
        const std::lock_guard lock(mutex_);
        last_ = Clock::now(), phase_ = std::move(phase);
    }

private:
    using Clock = std::chrono::steady_clock;
    void watch()
    {
        std::unique_lock lock(mutex_);
        while (!wake_.wait_for(lock, std::chrono::milliseconds(100), [&] { return over_; })) {
            if (Clock::now() - last_ < limit_) continue;
            write_to_stderr(fmt::format("oncollide: process {}: {} has not ended for {} s; another process hangs, or "
                                        "--patience is too short\n",
                                        rank_, phase_, limit_.count()));
            std::_Exit(int(ErrorKind::internal)); // mpirun then ends the other processes
        }
    }

    std::chrono::seconds limit_;
    int rank_;
    std::mutex mutex_;
    std::condition_variable wake_;
    bool over_ = false;
    std::string phase_ = "reading the scene";
    Clock::time_point last_ = Clock::now();
    std::thread thread_;
};

void check_rank_outputs(const OutputOptions& outputs)
{
    if (!outputs.json.empty() || !outputs.picture.empty())
        usage("--json and --picture need a single process without checkpoints; with several processes use --csv");
    std::error_code error;
    if (outputs.csv == "-" || (fs::exists(outputs.csv, error) && !fs::is_regular_file(outputs.csv, error)))
        usage(fmt::format("--csv {}: several processes write it at once; name a regular file", outputs.csv));
}

bool anyone_interrupted(Ranks& ranks)
{
    std::uint64_t stop = interrupted();
    ranks.sum({&stop, 1});
    return stop != 0;
}

class Play {
public:
    Play(Ranks& ranks, const SceneOptions& scene, const OutputOptions& outputs, const RankOptions& options)
        : ranks_(ranks), scene_(scene), outputs_(outputs), options_(options), watchdog_(options.patience, ranks.rank()),
          speaks_(ranks.rank() == 0 && !outputs.quiet)
    {
    }

    int run(const SettingsOptions& how)
    {
        Settings settings;
        SceneSlice slice;
        RankedOptions ranked{.csv = outputs_.csv,
                             .separate = outputs_.separate,
                             .continuous = options_.continuous,
                             .trace = !outputs_.trace.empty(),
                             .checkpoint = options_.checkpoint,
                             .checkpoint_every = options_.checkpoint_every,
                             .resume = options_.resume};
        together(ranks_, [&] {
            if (!options_.not_for_ranks.empty())
                usage(options_.not_for_ranks +
                      ": needs a single process, without mpirun, checkpoints and --process-csv");
            settings = settings_from(how);
            check_for_ranks(settings);
            ranked.rebalance = rebalance_from_name(options_.rebalance);
            check_range("--checkpoint-every", options_.checkpoint_every, 1);
            check_range("--patience", options_.patience, 1);
            if (options_.partitioner == "zoltan" && speaks_)
                log(LogLevel::note, "--partitioner zoltan: Zoltan is not used; regions are ranges of Morton keys");
            else if (options_.partitioner != "morton" && options_.partitioner != "zoltan")
                usage(fmt::format("--partitioner: unknown name '{}'; valid: morton", options_.partitioner));
            if (options_.resume && options_.checkpoint.empty()) usage("--resume needs --checkpoint FILE");
            check_rank_outputs(outputs_);
            if (ranks_.rank() == 0) check_files({{"--process-csv", options_.csv}});
            if (ranks_.rank() == 0) check_outputs(outputs_, is_scene_file(scene_.scene) ? scene_.scene : "");
            try {
                slice = read();
                check_for_ranks(slice.geometries, settings);
            } catch (const OverwritesInput& error) {
                usage(error.what());
            }
        });
        print_warnings_of_all(slice.warnings);
        if (speaks_ && slice.bodies < std::uint32_t(ranks_.size()))
            log(LogLevel::note,
                fmt::format("{} processes for {} bodies: some processes have no body", ranks_.size(), slice.bodies));
        title_ = slice.name.empty() ? "scene" : slice.name;
        const int frames = slice.frames;
        RankedRun run(ranks_, make_morton_partitioner(), std::move(slice), settings, ranked);
        return play(run, frames);
    }

private:
    SceneSlice read()
    {
        SliceReader reader(ranks_.rank(), ranks_.size(), !outputs_.csv.empty());
        return reader.finish(open_scene(scene_, reader));
    }
    /// Warnings of reading, without duplicates: each is printed once even if all processes report it.
    void print_warnings_of_all(const std::vector<std::string>& mine)
    {
        constexpr std::size_t enough = 100;
        std::vector<Bytes> out(std::size_t(ranks_.size())), in;
        for (std::size_t k = 0; k < std::min(enough, mine.size()); ++k) put_list(out[0], mine[k]);
        ranks_.exchange(out, in);
        std::vector<std::string> all;
        for (const Bytes& bytes : in)
            for (ByteReader reader(bytes); !reader.at_end();) {
                auto warning = reader.get_list<std::string>();
                if (std::ranges::find(all, warning) == all.end()) all.push_back(std::move(warning));
            }
        if (speaks_) log_warnings(all);
    }
    int play(RankedRun& run, int frames)
    {
        catch_interrupts();
        bool stopped = false;
        {
            Progress progress("frame", std::size_t(frames), !speaks_);
            while (run.frame() < frames && !stopped) {
                watchdog_.alive(fmt::format("frame {}", run.frame()));
                run.step();
                progress.step();
                stopped = anyone_interrupted(ranks_);
            }
        }
        watchdog_.alive("writing results");
        run.finish();
        report(run, frames);
        if (run.frame() == frames) return release_interrupts(), 0;
        if (ranks_.rank() == 0)
            log(LogLevel::error, fmt::format("interrupted after {} of {} frames", run.frame(), frames));
        return interrupted_code;
    }

    void report(RankedRun& run, int frames)
    {
        const std::uint64_t hash = run.hash();
        const auto verdicts = run.verdicts();
        const std::vector<StageStats> stages = run.totals();
        const std::vector<RankStatistics> ranks = run.statistics(peak_memory());
        const auto phases = run.phases();
        const std::string title = fmt::format(
            "{}: {} bodies, {} frame{}{}; {} process{}", title_, run.bodies(), run.frame(), run.frame() == 1 ? "" : "s",
            run.frame() < frames ? " (interrupted)" : "", ranks_.size(), ranks_.size() == 1 ? "" : "es");
        together(ranks_, [&] {
            if (ranks_.rank() != 0) return;
            if (speaks_) {
                write_to_stdout(fmt::format(
                    "{}\n\n{}sums of all processes, with ghosts; ms: the maximum of all processes\n\n{}regions    cut "
                    "{} time{}\n{}hash       {:016x}\n",
                    printable(title), stage_table(stages), rank_table(ranks), run.rebuilds(),
                    run.rebuilds() == 1 ? "" : "s", verdict_line(verdicts), hash));
                flush_stdout();
            }
            if (!options_.csv.empty()) write_rank_csv(options_.csv, ranks);
            if (!outputs_.trace.empty()) write_rank_trace(outputs_.trace, "oncollide " + title, phases);
        });
    }

    Ranks& ranks_;
    const SceneOptions& scene_;
    const OutputOptions& outputs_;
    const RankOptions& options_;
    RankWatchdog watchdog_;
    bool speaks_;
    std::string title_;
};

/// Process 0 prints the error; the others wait, because mpirun ends all processes when one ends.
[[noreturn]] void refuse_without_mpi()
{
    if (mpi_rank_of_environment() == 0) make_mpi_ranks();
    std::this_thread::sleep_for(std::chrono::seconds(2));
    std::_Exit(int(ErrorKind::usage));
}

} // namespace

void add_rank_options(Arguments command, RankOptions& o)
{
    command.add_option("--checkpoint FILE", o.checkpoint,
                       "write checkpoints to FILE.0 and FILE.1 in turn, for --resume");
    command.add_option("--checkpoint-every K", o.checkpoint_every, "frames between checkpoints (default 100)");
    command.add_flag("--resume", o.resume, "continue from the last checkpoint, on any number of processes");
    command.add_option("--rebalance WHEN", o.rebalance,
                       "under mpirun, when to divide space among the processes again: auto (default), always or never");
    command.add_option("--partitioner NAME", o.partitioner, "for old scripts: morton is the only one");
    command.add_option("--process-csv FILE", o.csv,
                       "under mpirun, write one row per process: its bodies, its work and the data it sent");
    command.add_option("--patience S", o.patience,
                       "under mpirun, most seconds per frame before the run ends with an error (default 600)");
}

bool wants_ranks(const RankOptions& o)
{
    return mpi_size_of_environment() > 1 || (started_by_mpi() && mpi_is_built()) || !o.checkpoint.empty() || o.resume ||
           !o.csv.empty();
}

int play_on_ranks(const SceneOptions& scene, const SettingsOptions& settings, const OutputOptions& outputs,
                  const RankOptions& options)
{
    int code = 0;
    const auto play = [&](Ranks& ranks) { code = Play(ranks, scene, outputs, options).run(settings); };
    if (!started_by_mpi()) {
        run_ranks_on_threads(1, play);
        return code;
    }
    if (!mpi_is_built()) refuse_without_mpi();
    const std::unique_ptr<Ranks> ranks = make_mpi_ranks();
    try {
        play(*ranks);
    } catch (const ErrorOfAll& error) {
        // mpirun ends all processes when the first one ends with a code, so no process ends before this is printed.
        code = int(error.kind());
        if (ranks->rank() == 0) log(LogLevel::error, error.what());
        std::uint64_t said = 1;
        ranks->sum({&said, 1});
    } catch (const std::exception& error) { // only this process failed, and the others wait for it
        const Error* known = dynamic_cast<const Error*>(&error);
        code = int(known ? known->kind() : ErrorKind::internal);
        log(LogLevel::error, fmt::format("process {}: {}", ranks->rank(), error.what()));
        ranks->abort(code);
    }
    return code;
}

} // namespace oncollide::tools
