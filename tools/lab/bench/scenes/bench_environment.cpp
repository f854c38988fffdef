// oncollide-lab bench environment: many bodies in large environments, with several error bounds and exactly, against
// FCL.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>

#include "bench/bench.hpp"
#include "bench/scenes/environment_scenes.hpp"
#include "bench/scenes/scene_race.hpp"
#include "cli/options.hpp"
#include "cli/progress.hpp"
#include "cli/shard.hpp"
#include "cli/system.hpp"
#include "common/line_plot.hpp"
#include "common/text.hpp"

namespace oncollide::tools {

namespace {

struct EnvironmentOptions {
    EnvironmentChoice in{.bodies = 500};
    std::string errors = "1,0.1,0.01,exact";
    int frames = 10, warm_up = 3, cold_runs = 1, threads = 1;
    int repeats = 1; ///< runs over all frames; the least time of each frame counts
    std::string csv, plot, shard;
};

struct Dial {
    std::string text; ///< "0.1" or "exact"
    Settings settings;
};

std::vector<Dial> dials_of(const EnvironmentOptions& o)
{
    std::vector<Dial> dials;
    for (const std::string& text : split(o.errors)) {
        Dial dial{text, {.threads = o.threads}};
        if (text == "exact") {
            dial.settings.exact = ExactLevel::predicates;
        } else {
            char* end = nullptr;
            const double error = std::strtod(text.c_str(), &end);
            if (text.empty() || *end != 0 || !(error > 0) || !std::isfinite(error))
                usage(fmt::format("--errors {}: expected lengths in metres above 0, and 'exact', such as 1,0.1,exact",
                                  o.errors));
            dial.settings.max_error = error;
        }
        check(dial.settings);
        dials.push_back(std::move(dial));
    }
    return dials;
}

/// One environment with one error bound.
struct Row {
    std::string environment, bodies_of, error;
    double fcl_ms = 0, our_ms = 0, fcl_first_ms = 0, our_first_ms = 0, fcl_mb = 0, our_mb = 0, peak = 0;
    std::uint64_t pairs = 0, left_over = 0, colliding = 0, false_positives = 0, missed = 0, wrong = 0, hash = 0;
    std::string first_missed;
};

Row row_of(const EnvironmentOptions& o, const EnvironmentScene& which, const Dial& dial, Scene& scene)
{
    CompareOptions race_options;
    race_options.repeats = o.repeats, race_options.cold_runs = o.cold_runs;
    SceneRuns runs = race(race_options, dial.settings, scene);
    Row row;
    row.environment = which.environment, row.bodies_of = which.bodies_of, row.error = dial.text;
    const auto warm_up = std::size_t(std::min(o.warm_up, scene.frames - 1));
    const double frames = double(runs.rows.size() - warm_up);
    for (std::size_t i = 0; i < runs.rows.size(); ++i) {
        const SceneRow& frame = runs.rows[i];
        row.missed += frame.counts.missed, row.wrong += frame.counts.wrong_exact;
        if (row.first_missed.empty()) row.first_missed = frame.counts.first_missed;
        if (i < warm_up) continue;
        row.fcl_ms += frame.fcl_ms / frames, row.our_ms += frame.our_ms / frames;
        row.pairs += frame.counts.pairs, row.left_over += frame.counts.left_over;
        row.colliding += frame.counts.colliding, row.false_positives += frame.counts.false_positives;
    }
    row.fcl_first_ms = median(runs.fcl_cold), row.our_first_ms = median(runs.our_cold);
    row.fcl_mb = double(runs.fcl_bytes.obb) / 1e6, row.our_mb = double(runs.our_bytes) / 1e6;
    row.peak = double(peak_memory()) / 1e6, row.hash = runs.hash;
    return row;
}

void print(const Row& row)
{
    say("{:<11} {:<7} {:>6} {:>9.3f} {:>9.3f} {:>7.2f} {:>10.1f} {:>10.1f} {:>8.1f} {:>8.1f} {:>10} {:>10} {:>9}\n",
        row.environment, row.bodies_of, row.error, row.fcl_ms, row.our_ms, row.fcl_ms / row.our_ms, row.fcl_first_ms,
        row.our_first_ms, row.fcl_mb, row.our_mb, grouped(row.pairs), grouped(row.left_over),
        grouped(row.false_positives));
    if (row.missed || row.wrong) say("MISSED     {} ({} wrong): {}\n", row.missed, row.wrong, row.first_missed);
}

void write_csv(const std::string& path, const std::string& head, const std::vector<Row>& rows, int threads)
{
    CsvFile csv(path,
                "environment,bodies,error,threads,fcl_ms,ms,ratio,fcl_first_ms,first_ms,fcl_mb,trees_mb,process_mb,"
                "pairs,left_over,colliding,false_positives,missed,hash",
                head);
    for (const Row& r : rows)
        csv.row(r.environment, r.bodies_of, r.error, threads, Digits{r.fcl_ms, 6}, Digits{r.our_ms, 6},
                Digits{r.fcl_ms / r.our_ms, 4}, Digits{r.fcl_first_ms, 6}, Digits{r.our_first_ms, 6},
                Digits{r.fcl_mb, 6}, Digits{r.our_mb, 6}, Digits{r.peak, 6}, r.pairs, r.left_over, r.colliding,
                r.false_positives, r.missed, Hex{r.hash});
    csv.commit();
}

void write_plot(const std::string& path, const std::vector<Row>& rows, const std::vector<Dial>& dials)
{
    std::vector<PlotPanel> panels;
    for (std::size_t first = 0; first < rows.size(); first += dials.size()) {
        PlotLine fcl{PlotLine::Weight::peer, "FCL", {}, 1}, ours{PlotLine::Weight::main, "oncollide", {}, 0};
        for (std::size_t k = 0; k < dials.size(); ++k) {
            fcl.points.push_back({double(k), rows[first + k].fcl_ms});
            ours.points.push_back({double(k), rows[first + k].our_ms});
        }
        panels.push_back({rows[first].environment + ", " + rows[first].bodies_of, {fcl, ours}});
    }
    PlotAxes axes{"error, metres", "ms per frame", [](double ms) { return plain_measure(ms, 3) + " ms"; }};
    for (const Dial& dial : dials) axes.x_names.push_back(dial.text);
    OutputFile file(path);
    draw_line_plot(file, panels, axes);
    file.commit();
}

/// Large environments with many bodies, compared with FCL. Returns the exit code: 70 if oncollide missed a collision or
/// one of its exact results is wrong.
int bench_environment(const EnvironmentOptions& o)
{
    check_range("--bodies", o.in.bodies, 1, 1'000'000), check_range("--frames", o.frames, 1, 100'000);
    check_range("--warm-up", o.warm_up, 0), check_range("--cold-runs", o.cold_runs, 1, 100);
    check_range("--repeats", o.repeats, 1, 100);
    check_files({{"--csv", o.csv}, {"--plot", o.plot}});
    const std::vector<Dial> dials = dials_of(o);
    std::vector<EnvironmentScene> scenes = scenes_of(o.in, o.frames);
    const Shard shard = shard_from(o.shard);
    keep_part(shard, scenes, "environments with their bodies");
    say("{}{} bodies in each environment; FCL reports collisions, oncollide is certified to the error bound\n\n",
        describe_program("environments"), grouped(std::uint64_t(o.in.bodies)));
    say("{:<11} {:<7} {:>6} {:>9} {:>9} {:>7} {:>10} {:>10} {:>8} {:>8} {:>10} {:>10} {:>9}\n", "environment", "bodies",
        "error", "FCL ms", "ms", "ratio", "FCL first", "first ms", "FCL MB", "MB", "pairs", "left over", "false");
    std::vector<Row> rows;
    for (const EnvironmentScene& which : scenes) {
        Scene scene = make_environment_scene(which);
        for (const Dial& dial : dials) {
            rows.push_back(row_of(o, which, dial, scene));
            print(rows.back());
        }
    }
    say("\nThe process held {:.0f} MB at most, including FCL's models and the environments.\n",
        double(peak_memory()) / 1e6);
    write_csv(o.csv,
              shard.line(fmt::format("bench environment, {}, errors {}, {} frames", o.in.work(), o.errors, o.frames)),
              rows, o.threads);
    if (!o.plot.empty()) write_plot(o.plot, rows, dials);
    const bool faulty = std::ranges::any_of(rows, [](const Row& row) { return row.missed || row.wrong; });
    return faulty ? int(ErrorKind::internal) : 0;
}

} // namespace

void add_environment(Arguments bench)
{
    Arguments sub = bench.add_command("environment", "Many bodies in buildings and on terrains, with several error "
                                                     "bounds");
    auto options = std::make_shared<EnvironmentOptions>();
    add_environment_choice(sub, options->in);
    sub.add_option("--errors LIST", options->errors, "error bounds in metres, and 'exact' (default 1,0.1,0.01,exact)");
    sub.add_option("--frames N", options->frames, "frames to play (default 10)");
    sub.add_option("--warm-up N", options->warm_up, "frames at the start that are not timed (default 3)");
    sub.add_option("--repeats N", options->repeats, "number of runs; each frame's least time counts (default 1)");
    sub.add_option("--cold-runs N", options->cold_runs, "number of cold starts (default 1)");
    sub.add_option("--threads N", options->threads, "threads of oncollide; 0: all (default 1)");
    sub.add_option("--csv FILE", options->csv, "write one row per environment, bodies and error");
    sub.add_option("--shard I/N", options->shard,
                   std::string("divide the environments with their bodies among N processes: ") + shard_help);
    sub.add_option("--plot FILE.svg", options->plot, "draw time against error, one panel per environment");
    sub.footer("Examples:\n"
               "  oncollide-lab bench environment --environments building --bodies 50 --errors 0.1,exact\n"
               "  oncollide-lab bench environment --environments hills,hills-mesh --cells 2200 --bodies 1000\n"
               "'first': from the geometry in memory to the first frame's results. Exit code 70: a collision was\n"
               "missed, or an exact result is wrong.");
    sub.action([options] { return bench_environment(*options); });
}

} // namespace oncollide::tools
