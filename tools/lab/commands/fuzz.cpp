// oncollide-lab fuzz: small random scenes and motions, checked against the truth and against each other.
#include "commands/lab.hpp"
#include "common/text.hpp"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

#include "cli/outputs.hpp"
#include "cli/progress.hpp"
#include "cli/standard_output.hpp"
#include "verify/trials/differential.hpp"
#include "verify/trials/graze_trial.hpp"
#include "verify/trials/sweep_trial.hpp"

namespace oncollide::tools {
namespace {

struct FuzzOptions {
    std::int64_t scenes = 10'000, sweeps = 0, grazes = 0;
    std::uint64_t seed = 1;
    int threads = 1;
    std::string out = "fault.json", csv;
};

/// Prints the fault. Returns the exit code.
int report_fault(const FirstFault& first)
{
    if (first.what.empty()) return 0;
    say("FAULT      seed {}: {}\n", first.seed, first.what);
    return int(ErrorKind::internal);
}

/// Returns the exit code.
int fuzz_sweeps(const FuzzOptions& options, int threads)
{
    Progress progress("sweeps", std::size_t(options.sweeps));
    const SweepTallies tallies =
        try_sweeps(options.seed, std::uint64_t(options.sweeps), threads, [&] { progress.step(); });
    SweepTally all;
    CsvFile csv(options.csv, "a,b,sweeps,contacts,at_start,clear,open,poses,truths,missed,early,wide,changed");
    const auto row = [&](const std::string& a, const std::string& b, const SweepTally& t) {
        csv.row(a, b, t.sweeps, t.contacts, t.at_start, t.clear, t.open, t.poses, t.truths, t.missed, t.early, t.wide,
                t.changed);
    };
    for (const auto& [kinds, tally] : tallies) row(kinds.first, kinds.second, tally), all += tally;
    row("all", "all", all);
    csv.commit();
    say("{} sweeps, seeds {} to {}: {} contacts on the way, {} at time 0, {} free, {} not decided\n"
        "{} poses by exact tests, {} by the truth: {} missed, {} early, {} out of tolerance, {} changed by the order "
        "of the bodies\n",
        options.sweeps, options.seed, options.seed + std::uint64_t(options.sweeps) - 1, all.contacts, all.at_start,
        all.clear, all.open, all.poses, all.truths, all.missed, all.early, all.wide, all.changed);
    return report_fault(tallies.first);
}

/// Returns the exit code.
int fuzz_grazes(const FuzzOptions& options, int threads)
{
    Progress progress("grazes", std::size_t(options.grazes));
    const GrazeTally all = try_grazes(options.seed, std::uint64_t(options.grazes), threads, [&] { progress.step(); });
    say("{} grazing sweeps, seeds {} to {}: {} with a certain contact, {} without, {} free, {} not decided: {} "
        "faults\n",
        all.sweeps, options.seed, options.seed + all.sweeps - 1, all.contacts, all.grazes, all.clear, all.open,
        all.faults);
    return report_fault(all.first);
}

int fuzz(const FuzzOptions& options)
{
    check_range("--scenes", options.scenes, options.sweeps + options.grazes > 0 ? 0 : 1);
    check_range("--sweeps", options.sweeps, 0), check_range("--grazes", options.grazes, 0);
    check_range("--threads", options.threads, 0, 1024);
    check_files({{"--out", options.out}, {"--csv", options.csv}});
    if (!options.csv.empty() && options.sweeps == 0) usage("--csv: it lists sweeps; give their number with --sweeps");
    const int threads = threads_of(options.threads);
    const int of_sweeps = options.sweeps > 0 ? fuzz_sweeps(options, threads) : 0;
    const int of_grazes = options.grazes > 0 ? fuzz_grazes(options, threads) : 0;
    if (options.scenes == 0) return std::max(of_sweeps, of_grazes);
    Progress progress("scenes", std::size_t(options.scenes));
    const FirstFault first =
        first_faulty_scene(options.seed, std::uint64_t(options.scenes), threads, [&] { progress.step(); });
    if (first.what.empty()) {
        write_to_stdout(fmt::format("{} scenes, seeds {} to {}: no fault\n", options.scenes, options.seed,
                                    options.seed + std::uint64_t(options.scenes) - 1));
        return std::max(of_sweeps, of_grazes);
    }
    const DrawnScene drawn = draw_scene(first.seed),
                     small = shrunk(drawn, [](const DrawnScene&d) { return !fault_in(d).empty(); });
    save_scene(small.scene, options.out);
    write_to_stdout(fmt::format("seed {}: {}\nreduced to {} bodies: {}\noncollide run {} {}\n", first.seed, first.what,
                                small.scene.size(), fault_in(small), options.out, options_of(small.settings)));
    return int(ErrorKind::internal);
}

} // namespace

void add_fuzz(Arguments app)
{
    Arguments sub = app.add_command("fuzz", "Check small random scenes against the truth and against each other");
    auto options = std::make_shared<FuzzOptions>();
    sub.add_option("--scenes N", options->scenes, "number of scenes (default 10000)");
    sub.add_option("--sweeps N", options->sweeps,
                   "number of sweeps of two moving bodies to check before the scenes (default 0)");
    sub.add_option("--grazes N", options->grazes,
                   "number of sweeps that slide, graze or fall through large plates, at all scales, to check against "
                   "closed forms before the scenes (default 0)");
    sub.add_option("--csv FILE", options->csv, "write one row of sweeps for each two kinds of geometry");
    sub.add_option("--seed S", options->seed,
                   "seed of the first scene, and of the first sweep; each next one has the next number (default 1)");
    sub.add_option("--threads N", options->threads, "number of threads; 0: all (default 1)");
    sub.add_option("--out FILE", options->out, "file for the smallest faulty scene (default fault.json)");
    sub.footer("Scenes of two to four meshes, shapes, maps and terrains, with all settings. Most are on a grid of 1/8, "
               "where touching is common. The truth comes from extended precision and shares no code with the library. "
               "Exit code 70: a fault was found; the scene is reduced to a small scene file, and the options are "
               "printed. Sweeps are judged by the truth of single poses before and at the contact, and with the bodies "
               "swapped.");
    sub.action([options] { return fuzz(*options); });
}

} // namespace oncollide::tools
