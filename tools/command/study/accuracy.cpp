// oncollide accuracy SCENE: a study whose table says whether every collision is found and every bound holds.
#include "cli/command.hpp"
#include "common/text.hpp"
#include "play/compared.hpp"
#include "render/backend_trial.hpp"
#include "study/play.hpp"
#include "truth/setting_variants.hpp"

#include <algorithm>
#include <memory>
#include <numeric>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/narrowphase/fcl/exact_fcl.hpp>
#include <oncollide/narrowphase/spheres/occlusion_backend.hpp>
#include <oncollide/samples/catalogue.hpp>

namespace oncollide::tools {
namespace {

struct AccuracyOptions {
    SceneOptions scene;
    SettingsOptions settings;
    std::string depths = "1-8", csv, json;
    bool toggle = false;
    int count = 1, samples = 10, every = 1;
};

/// A way to run the pipeline, judged over all frames of all scenes.
struct JudgedVariant : FrameJudgement {
    std::string name;
    Settings settings;
    bool same_hash = false; ///< must give the same hash as the plain variant of its depth
    std::size_t plain = 0;  ///< that variant

    std::uint64_t frames = 0, other_hash = 0, fcl_colliding = 0, fcl_alone = 0;
    std::array<std::uint64_t, 4> verdicts{};
    double ms = 0;

    std::uint64_t count(Verdict verdict) const { return verdicts[std::size_t(verdict)]; }
    std::uint64_t pairs() const { return std::accumulate(verdicts.begin(), verdicts.end(), std::uint64_t(0)); }
    std::uint64_t left_over() const { return pairs() - count(Verdict::separate); }
    std::uint64_t violations() const { return missed + wrong + broken + other_hash; }
    double ms_per_frame() const { return ms / double(std::max<std::uint64_t>(frames, 1)); }
};

/// Makes a variant per depth with the settings as given; with `toggle` also one per single change of the settings.
std::vector<JudgedVariant> make_variants(const AccuracyOptions& options)
{
    std::vector<JudgedVariant> variants;
    for (int depth : parse_depths("--depths", options.depths)) {
        Settings plain = with_tried_backend(settings_from(options.settings));
        plain.max_error.reset(), plain.depth = depth;
        const std::size_t first = variants.size();
        const auto add = [&](const std::string& changes, bool same_hash = false) {
            SettingVariant variant{"", plain};
            variant.change(changes);
            JudgedVariant& v = variants.emplace_back();
            v.name = changes.empty() ? "as given" : changes, v.settings = variant.settings;
            v.same_hash = same_hash, v.plain = first;
        };
        add("");
        if (!options.toggle) continue;
        for (const SettingChange& change : changes_without_stage().first(4)) // the exact level has its own variants
            add(change.name);
        for (const SettingChange& change : changes_of_method()) add(change.name, true);
        add("100 cells");
        if (fcl_available()) add("exact fcl"), add("exact fcl, without refine");
    }
    return variants;
}

/// Plays a scene as a study with FCL, and adds its results. Returns the backend that ran.
std::string play(StudyWorkload& workload, const AccuracyOptions& options, std::vector<JudgedVariant>& variants)
{
    std::vector<StudyVariant> played;
    for (const JudgedVariant& v : variants) played.push_back({"", v.name, v.settings});
    const std::vector<PeerKind> peers = fcl_available() ? std::vector{fcl_peer()} : std::vector<PeerKind>();
    const Study study = play_study(workload, played, peers,
                                   {.bounds = std::size_t(options.samples), .any_peer = true, .needed = false});
    for (std::size_t k = 0; k < variants.size(); ++k) {
        const StudyRow& row = study.rows[k];
        JudgedVariant& v = variants[k];
        v += row;
        v.frames += row.ms.size(), v.ms += std::accumulate(row.ms.begin(), row.ms.end(), 0.0);
        for (const StudyPeer& peer : study.peers) v.fcl_colliding += peer.colliding;
        v.fcl_alone += row.fcl_alone;
        for (std::size_t i = 0; i < v.verdicts.size(); ++i) v.verdicts[i] += row.verdicts[i];
        for (std::size_t i = 0; i < row.hashes.size() && v.same_hash; ++i)
            v.other_hash += row.hashes[i] != study.rows[v.plain].hashes[i];
    }
    return study.rows.front().backend;
}

std::string optional_length(double value, bool known)
{
    return known ? fmt::format("{:.3g}", value) : "-";
}

void print_table(const std::vector<JudgedVariant>& variants)
{
    say("{:>5}  {:<26}{:>8}{:>11}{:>11}{:>11}{:>9}{:>8}{:>9}{:>11}{:>9}{:>11}{:>11}{:>7}{:>10}\n", "depth", "variant",
        "frames", "pairs", "left over", "colliding", "false", "missed", "rounding", "bounds", "broken", "margin m",
        "bound m", "hash", "ms/frame");
    for (const JudgedVariant& v : variants)
        say("{:>5}  {:<26}{:>8}{:>11}{:>11}{:>11}{:>9}{:>8}{:>9}{:>11}{:>9}{:>11}{:>11}{:>7}{:>10.3f}\n",
            *v.settings.depth, v.name, v.frames, v.pairs(), v.left_over(), v.fcl_colliding, v.false_positives,
            v.missed + v.wrong, v.fcl_alone, v.bounds, v.broken, optional_length(v.least_margin, v.bounds),
            optional_length(v.largest_bound, v.largest_bound > 0), v.same_hash ? (v.other_hash ? "DIFF" : "same") : "",
            v.ms_per_frame());
    for (const JudgedVariant& v : variants)
        if (!v.first_fault.empty()) say("FAULT      depth {}, {}: {}\n", *v.settings.depth, v.name, v.first_fault);
}

void write_csv(const std::string& path, const std::vector<JudgedVariant>& variants)
{
    CsvFile csv(path, "depth,variant,frames,pairs,left_over,undecided,colliding,fcl_colliding,false_positives,missed,"
                      "missed_by_rounding,wrong_exact,bound_checks,bound_violations,least_margin,largest_bound,"
                      "other_hash,ms_per_frame");
    for (const JudgedVariant& v : variants)
        csv.row(*v.settings.depth, v.name, v.frames, v.pairs(), v.left_over(), v.count(Verdict::undecided),
                v.count(Verdict::colliding), v.fcl_colliding, v.false_positives, v.missed, v.fcl_alone, v.wrong,
                v.bounds, v.broken, v.bounds ? v.least_margin : 0, v.largest_bound, v.other_hash, v.ms_per_frame());
    csv.commit();
}

void write_json(const std::string& path, const std::string& scene, const std::vector<JudgedVariant>& variants)
{
    OutputFile file(path);
    JsonWriter json(file);
    json.begin_object(), json.schema("oncollide.accuracy", 1);
    json.key("header"), json.object("version", version, "scene", scene);
    json.key("variants"), json.begin_array();
    for (const JudgedVariant& v : variants) {
        json.line(2);
        json.object("depth", *v.settings.depth, "variant", v.name, "frames", v.frames, "pairs", v.pairs(), "left_over",
                    v.left_over(), "undecided", v.count(Verdict::undecided), "colliding", v.count(Verdict::colliding),
                    "fcl_colliding", v.fcl_colliding, "false_positives", v.false_positives, "missed", v.missed,
                    "missed_by_rounding", v.fcl_alone, "wrong_exact", v.wrong, "bound_checks", v.bounds,
                    "bound_violations", v.broken, "other_hash", v.other_hash, "ms_per_frame", v.ms_per_frame());
    }
    json.line(), json.end_array();
    json.end_object();
    file.write("\n");
    file.commit();
}

int accuracy(const AccuracyOptions& options)
{
    if (options.scene.scene.empty())
        throw Error(ErrorKind::usage, "accuracy: a scene is required (oncollide accuracy --help)");
    const std::string& word = options.scene.scene; // a misspelt subcommand ends up here
    if (const std::string hint = did_you_mean(word, {"continuous", "study"}); !hint.empty() && !is_scene_file(word))
        if (std::ranges::find(catalogue(), word, &CatalogueEntry::name) == catalogue().end())
            usage(fmt::format("accuracy: '{}' is neither a command nor a scene{} (scenes: oncollide scene --list)",
                              word, hint));
    check_range("--count", options.count, 1), check_range("--samples", options.samples, 0),
        check_range("--every", options.every, 1);
    if (options.count > 1 && is_scene_file(options.scene.scene))
        throw Error(ErrorKind::usage, "--count applies only to scenes of the catalogue: it counts seeds");
    check_files({{"--csv", options.csv}, {"--json", options.json}});
    std::vector<JudgedVariant> variants = make_variants(options);
    const auto violations = [&] {
        std::uint64_t sum = 0;
        for (const JudgedVariant& v : variants) sum += v.violations();
        return sum;
    };
    std::string name, backend;
    for (int k = 0; k < options.count; ++k) {
        SceneOptions one = options.scene;
        if (options.count > 1) one.seed = one.seed.value_or(CatalogueOptions{}.seed) + std::uint64_t(k);
        StudyWorkload workload({.what = {one.scene}, .scene = one, .every = options.every});
        name = workload.title;
        if (options.count == 1) print_warnings(workload.scene);
        if (const std::string why = why_nothing_is_compared(workload.scene); !why.empty())
            refuse(options.scene.scene, why + ", so there is nothing to judge");
        const std::uint64_t before = violations();
        backend = play(workload, options, variants);
        if (options.count > 1 && violations() > before) say("FAULT      first seen with --seed {}\n", *one.seed);
    }
    say("scene      {}{}; compared with the truth and FCL in every {}frame, with {} bounds per frame and variant\n"
        "settings   {}\n{}\n",
        printable(name), options.count > 1 ? fmt::format(", {} seeds", options.count) : "",
        options.every > 1 ? fmt::format("{}-th ", options.every) : "", options.samples,
        describe(with_tried_backend(settings_from(options.settings)), "depths " + options.depths),
        describe_program(backend));
    print_table(variants);
    write_csv(options.csv, variants);
    if (!options.json.empty()) write_json(options.json, name, variants);
    const std::uint64_t sum = violations();
    say("\n{}\n", sum ? fmt::format("{} VIOLATIONS", sum)
                      : "no collision missed, no bound broken, no unexpected change of a result");
    return sum ? int(ErrorKind::internal) : 0;
}

} // namespace

void add_accuracy(Arguments app)
{
    Arguments sub = app.add_command(
        "accuracy", "Check the results of a scene against the truth: missed collisions, false positives, bounds");
    auto options = std::make_shared<AccuracyOptions>();
    // Not marked as required: CLI11 would then take a subcommand's name for the scene.
    sub.add_option("scene SCENE.json|NAME", options->scene.scene,
                   "scene file, or a name from 'oncollide scene --list'");
    add_accuracy_continuous(sub);
    add_accuracy_study(sub);
    sub.at_most_one_command(); // words after a subcommand belong to it
    sub.add_option("--depths LIST", options->depths, "depths to check (default 1-8)");
    sub.add_flag("--toggle", options->toggle,
                 "also check with each stage skipped and each setting changed, one at a time");
    sub.add_option("--count N", options->count, "number of scenes, each with the next seed");
    sub.add_option("--every N", options->every, "process only every N-th frame");
    sub.add_option("--samples N", options->samples, "number of bounds to check per frame (default 10)");
    add_catalogue_options(sub, options->scene);
    add_accuracy_options(sub, options->settings);
    sub.remove_option("--depth");
    sub.remove_option("--max-error");
    add_pipeline_options(sub, options->settings);
    sub.add_option("--csv FILE", options->csv, "write one row per variant");
    sub.add_option("--json FILE", options->json, "write the same as JSON");
    sub.footer("Examples:\n"
               "  oncollide accuracy paper --every 20\n"
               "  oncollide accuracy random --count 200 --frames 3 --depths 1-8 --toggle\n"
               "  oncollide accuracy study paper --html study.html    (speed against error; see its own --help)\n"
               "Hard cases and random scenes: oncollide-lab hard, oncollide-lab fuzz.\n"
               "Exit code 70: a collision was missed, a bound was broken, or a result changed unexpectedly.");
    sub.action([options] { return accuracy(*options); });
}

} // namespace oncollide::tools
