// oncollide-lab bench environment: many bodies in large environments, with several error bounds and exactly, against
// FCL.
#include <algorithm>
#include <cmath>

#include "bench/scenes/environment_scenes.hpp"
#include "bench/scenes/scene_race.hpp"
#include "cli/progress.hpp"
#include "cli/system.hpp"
#include "common/line_plot.hpp"

namespace oncollide::tools {

namespace {

struct EnvironmentOptions : SharedOptions {
    EnvironmentChoice in{.bodies = 500};
    std::string errors = "1,0.1,0.01,exact";
    int frames = 10, warm_up = 3, cold_runs = 1;
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

/// The times of one environment with one error bound, per frame.
struct Row {
    std::string title;
    double fcl_ms = 0, our_ms = 0;
    bool faulty = false;
};

Row run(const EnvironmentOptions& o, const EnvironmentScene& which, const Dial& dial, Scene& scene, ResultTable& table)
{
    CompareOptions race_options;
    race_options.repeats = o.repeats, race_options.cold_runs = o.cold_runs;
    const SceneRuns runs = race(race_options, dial.settings, scene);
    const auto warm_up = std::size_t(std::min(o.warm_up, scene.frames - 1));
    Row row{which.environment + ", " + which.bodies_of};
    Comparison all, timed;
    for (std::size_t i = 0; i < runs.rows.size(); ++i) {
        const SceneRow& frame = runs.rows[i];
        all += frame.counts;
        if (i < warm_up) continue;
        timed += frame.counts;
        row.fcl_ms += frame.fcl_ms / double(runs.rows.size() - warm_up);
        row.our_ms += frame.our_ms / double(runs.rows.size() - warm_up);
    }
    table.row(figures("environment", which.environment, "bodies", which.bodies_of, "error", dial.text, "fcl_ms",
                      row.fcl_ms, "ms", row.our_ms, "ratio", row.fcl_ms / row.our_ms, "fcl_first_ms",
                      median(runs.fcl_cold), "first_ms", median(runs.our_cold), "fcl_mb",
                      1e-6 * double(runs.fcl_bytes.obb), "trees_mb", 1e-6 * double(runs.our_bytes), "pairs",
                      timed.pairs, "left_over", timed.left_over, "false_positives", timed.false_positives),
              figures("threads", o.threads, "process_mb", 1e-6 * double(peak_memory()), "colliding", timed.colliding,
                      "missed", all.missed, "hash", Hex{runs.hash}));
    row.faulty = all.missed > 0 || all.wrong_exact > 0;
    if (row.faulty) say("MISSED     {} ({} wrong): {}\n", all.missed, all.wrong_exact, all.first_missed);
    return row;
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
        panels.push_back({rows[first].title, {fcl, ours}});
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
    const std::vector<Dial> dials = dials_of(o);
    std::vector<EnvironmentScene> scenes = scenes_of(o.in, o.frames);
    const Shard shard = shard_from(o.shard);
    keep_part(shard, scenes, "environments with their bodies");
    say("{}{} bodies in each environment; FCL reports collisions, oncollide is certified to the error bound, in "
        "metres\n\n",
        describe_program("environments"), grouped(std::uint64_t(o.in.bodies)));
    ResultTable table(
        o.csv, {},
        shard.line(fmt::format("bench environment, {}, errors {}, {} frames", o.in.work(), o.errors, o.frames)));
    std::vector<Row> rows;
    for (const EnvironmentScene& which : scenes) {
        Scene scene = make_environment_scene(which);
        for (const Dial& dial : dials) rows.push_back(run(o, which, dial, scene, table));
    }
    say("\nThe process held {:.0f} MB at most, including FCL's models and the environments.\n",
        double(peak_memory()) / 1e6);
    table.commit();
    if (!o.plot.empty()) write_plot(o.plot, rows, dials);
    return code_of(std::ranges::any_of(rows, &Row::faulty));
}

} // namespace

void add_environment(Arguments bench)
{
    Benchmark<EnvironmentOptions> b(
        bench, "environment", "Many bodies in buildings and on terrains, with several error bounds", bench_environment);
    b->repeats = 1;
    add_environment_choice(b, b->in, 1'000'000);
    b.option("--errors LIST", b->errors, "error bounds in metres, and 'exact' (default 1,0.1,0.01,exact)");
    b.whole("--frames N", b->frames, "frames to play", {1, 100'000});
    b.whole("--warm-up N", b->warm_up, "frames at the start that are not timed", {0});
    b.repeats("number of runs; each frame's least time counts");
    b.whole("--cold-runs N", b->cold_runs, "number of cold starts", {1, 100});
    b.option("--threads N", b->threads, "threads of oncollide; 0: all (default 1)");
    b.csv("environment, bodies and error"), b.shard("environments with their bodies");
    b.plot("time against error, one panel per environment");
    b.footer("Examples:\n"
             "  oncollide-lab bench environment --environments building --bodies 50 --errors 0.1,exact\n"
             "  oncollide-lab bench environment --environments hills,hills-mesh --cells 2200 --bodies 1000\n"
             "'first': from the geometry in memory to the first frame's results. Exit code 70: a collision was\n"
             "missed, or an exact result is wrong.");
}

} // namespace oncollide::tools
