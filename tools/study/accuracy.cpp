// oncollide accuracy: checks with FCL that every collision is found and every bound holds.
#include "bench/bench.hpp"
#include "cli/command.hpp"
#include "study/accuracy_check.hpp"
#include "verify/setting_variants.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/json_writer.hpp>
#include <oncollide/base/near_word.hpp>
#include <oncollide/base/output_file.hpp>
#include <oncollide/base/printable.hpp>
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
struct Variant {
    std::string name;
    Settings settings;
    bool same_hash = false; ///< must give the same hash as the plain variant of its depth
    std::size_t plain = 0;  ///< that variant

    std::uint64_t frames = 0, other_hash = 0;
    double ms = 0;
    Comparison counts;
    BoundCheck bounds;

    std::uint64_t violations() const { return counts.missed + counts.wrong_exact + bounds.violations + other_hash; }
    double ms_per_frame() const { return ms / double(std::max<std::uint64_t>(frames, 1)); }
};

/// Makes a variant per depth with the settings as given; with `toggle` also one per single change of the settings.
std::vector<Variant> make_variants(const AccuracyOptions& options)
{
    std::vector<Variant> variants;
    for (int depth : parse_depths("--depths", options.depths)) {
        Settings plain = settings_from(options.settings);
        plain.max_error.reset(), plain.depth = depth;
        const std::size_t first = variants.size();
        const auto add = [&](std::string name, bool same_hash, auto change) {
            Variant& v = variants.emplace_back();
            v.name = std::move(name), v.settings = plain, v.same_hash = same_hash, v.plain = first;
            change(v.settings);
        };
        add("as given", false, [](Settings&) {});
        if (!options.toggle) continue;
        for (const StageId stage : std::span(all_stages).first(4)) // the exact level has its own variants
            add(without_stage(stage).name, false, without_stage(stage).apply);
        for (const SettingChange& change : changes_of_method()) add(change.name, true, change.apply);
        add("100 cells", false, [](Settings& s) { s.node_budget = 100; });
        add("exact fcl", false, [](Settings& s) { s.exact = ExactLevel::fcl; });
        add("fcl, no refine", false, [](Settings& s) { s.exact = ExactLevel::fcl, s.skip.insert(StageId::refine); });
    }
    return variants;
}

/// FCL's distances in a frame; each is computed once for all variants.
class Distances {
public:
    explicit Distances(FclWorld& world) : world_(world) {}
    double operator()(BodyPair pair)
    {
        const auto [at, fresh] = known_.try_emplace(pair, 0.0);
        if (fresh) at->second = world_.distance(pair);
        return at->second;
    }
    void next_frame() { known_.clear(); }

private:
    FclWorld& world_;
    std::map<BodyPair, double> known_;
};

/// Checks the bounds of at most `samples` pairs, evenly spread over the list; the choice differs from frame to frame.
BoundCheck check_bounds(const Scene& scene, const FrameView& frame, const Settings& settings, int samples,
                        const FclWorld& world, Distances& distance)
{
    BoundCheck sum;
    const std::size_t step = std::max<std::size_t>(1, frame.pairs.size() / std::size_t(std::max(samples, 1)));
    for (std::size_t i = frame.frame % step; i < frame.pairs.size() && samples > 0; i += step) {
        const PairResult& pair = frame.pairs[i];
        const BodyPair bodies{index(pair.a), index(pair.b)};
        if (pair.verdict != Verdict::colliding)
            sum += check_bound(scene, pair, settings, distance(bodies), world.has_shape(bodies));
    }
    return sum;
}

/// Returns the backend that ran.
std::string judge(Scene& scene, const AccuracyOptions& options, std::vector<Variant>& variants)
{
    Mover mover;
    mover.move(scene, 0);
    FclWorld world(scene);
    Distances distance(world);
    std::vector<Pipeline> pipelines;
    for (const Variant& v : variants) pipelines.emplace_back(scene, v.settings);
    for (int frame = 0; frame < scene.frames; frame += options.every) {
        mover.move(scene, frame);
        const FclFrame fcl = world.step();
        distance.next_frame();
        std::vector<std::uint64_t> hashes;
        for (std::size_t k = 0; k < variants.size(); ++k) {
            Variant& v = variants[k];
            const FrameView view = pipelines[k].step(scene);
            v.counts += compare(scene, view, v.settings, fcl, world);
            v.bounds += check_bounds(scene, view, v.settings, options.samples, world, distance);
            v.ms += view.ms, ++v.frames;
            hashes.push_back(view.hash);
            v.other_hash += v.same_hash && view.hash != hashes[v.plain];
        }
    }
    return pipelines.front().inspect().backend;
}

std::string optional_length(double value, bool known)
{
    return known ? fmt::format("{:.3g}", value) : "-";
}

void print_table(const std::vector<Variant>& variants)
{
    say("{:>5}  {:<21}{:>8}{:>11}{:>11}{:>11}{:>9}{:>8}{:>9}{:>11}{:>9}{:>11}{:>11}{:>7}{:>10}\n", "depth", "variant",
        "frames", "pairs", "left over", "colliding", "false", "missed", "rounding", "bounds", "broken", "margin m",
        "bound m", "hash", "ms/frame");
    for (const Variant& v : variants)
        say("{:>5}  {:<21}{:>8}{:>11}{:>11}{:>11}{:>9}{:>8}{:>9}{:>11}{:>9}{:>11}{:>11}{:>7}{:>10.3f}\n",
            *v.settings.depth, v.name, v.frames, v.counts.pairs, v.counts.left_over, v.counts.fcl_colliding,
            v.counts.false_positives, v.counts.missed + v.counts.wrong_exact, v.counts.missed_by_rounding,
            v.bounds.checks, v.bounds.violations, optional_length(v.bounds.least_margin, v.bounds.checks),
            optional_length(v.bounds.largest_bound, v.bounds.largest_bound > 0),
            v.same_hash ? (v.other_hash ? "DIFF" : "same") : "", v.ms_per_frame());
    for (const Variant& v : variants)
        for (const std::string* fault : {&v.counts.first_missed, &v.bounds.first_violation})
            if (!fault->empty()) say("FAULT      depth {}, {}: {}\n", *v.settings.depth, v.name, *fault);
}

void write_csv(const std::string& path, const std::vector<Variant>& variants)
{
    CsvFile csv(path, "depth,variant,frames,pairs,left_over,undecided,colliding,fcl_colliding,false_positives,missed,"
                      "missed_by_rounding,wrong_exact,bound_checks,bound_violations,least_margin,largest_bound,"
                      "other_hash,ms_per_frame");
    for (const Variant& v : variants)
        csv.row(*v.settings.depth, v.name, v.frames, v.counts.pairs, v.counts.left_over, v.counts.undecided,
                v.counts.colliding, v.counts.fcl_colliding, v.counts.false_positives, v.counts.missed,
                v.counts.missed_by_rounding, v.counts.wrong_exact, v.bounds.checks, v.bounds.violations,
                v.bounds.checks ? v.bounds.least_margin : 0, v.bounds.largest_bound, v.other_hash, v.ms_per_frame());
    csv.commit();
}

void write_json(const std::string& path, const std::string& scene, const std::vector<Variant>& variants)
{
    OutputFile file(path);
    JsonWriter json(file);
    json.begin_object();
    json.key("header"), json.object("version", version, "scene", scene);
    json.key("variants"), json.begin_array();
    for (const Variant& v : variants) {
        json.line(2);
        json.object("depth", *v.settings.depth, "variant", v.name, "frames", v.frames, "pairs", v.counts.pairs,
                    "left_over", v.counts.left_over, "undecided", v.counts.undecided, "colliding", v.counts.colliding,
                    "fcl_colliding", v.counts.fcl_colliding, "false_positives", v.counts.false_positives, "missed",
                    v.counts.missed, "missed_by_rounding", v.counts.missed_by_rounding, "wrong_exact",
                    v.counts.wrong_exact, "bound_checks", v.bounds.checks, "bound_violations", v.bounds.violations,
                    "other_hash", v.other_hash, "ms_per_frame", v.ms_per_frame());
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
    if (const std::string hint = did_you_mean(word, {"fuzz", "study"}); !hint.empty() && !is_scene_file(word))
        if (std::ranges::find(catalogue(), word, &CatalogueEntry::name) == catalogue().end())
            usage(fmt::format("accuracy: '{}' is neither a command nor a scene{} (scenes: oncollide scene --list)",
                              word, hint));
    check_range("--count", options.count, 1), check_range("--samples", options.samples, 0),
        check_range("--every", options.every, 1);
    if (options.count > 1 && is_scene_file(options.scene.scene))
        throw Error(ErrorKind::usage, "--count applies only to scenes of the catalogue: it counts seeds");
    check_files({{"--csv", options.csv}, {"--json", options.json}});
    std::vector<Variant> variants = make_variants(options);
    std::string name, backend;
    for (int k = 0; k < options.count; ++k) {
        SceneOptions one = options.scene;
        if (options.count > 1) one.seed = one.seed.value_or(CatalogueOptions{}.seed) + std::uint64_t(k);
        Scene scene = open_scene(one);
        name = scene.name;
        if (options.count == 1) print_warnings(scene);
        const auto before = [&] {
            std::uint64_t sum = 0;
            for (const Variant& v : variants) sum += v.violations();
            return sum;
        };
        const std::uint64_t faults = before();
        backend = judge(scene, options, variants);
        if (options.count > 1 && before() > faults) say("FAULT      first seen with --seed {}\n", *one.seed);
    }
    say("scene      {}{}; compared with FCL in every {}frame, with {} bounds per frame and variant\n"
        "settings   {}\n{}\n",
        printable(name), options.count > 1 ? fmt::format(", {} seeds", options.count) : "",
        options.every > 1 ? fmt::format("{}-th ", options.every) : "", options.samples,
        describe(settings_from(options.settings), "depths " + options.depths), describe_program(backend));
    print_table(variants);
    if (!options.csv.empty()) write_csv(options.csv, variants);
    if (!options.json.empty()) write_json(options.json, name, variants);
    std::uint64_t violations = 0;
    for (const Variant& v : variants) violations += v.violations();
    say("\n{}\n", violations ? fmt::format("{} VIOLATIONS", violations)
                             : "no collision missed, no bound broken, no unexpected change of a result");
    return violations ? int(ErrorKind::internal) : 0;
}

} // namespace

void add_accuracy(Arguments app)
{
    Arguments sub = app.add_command(
        "accuracy", "Check the results of a scene against FCL: missed collisions, false positives, bounds");
    auto options = std::make_shared<AccuracyOptions>();
    // Not marked as required: CLI11 would then take a subcommand's name for the scene.
    sub.add_option("scene", options->scene.scene, "scene file, or a name from 'oncollide scene --list'")
        .type_name("SCENE.json|NAME");
    add_accuracy_fuzz(sub);
    add_accuracy_hard(sub);
    add_accuracy_study(sub);
    sub.at_most_one_command(); // words after a subcommand belong to it, even 'hard'
    sub.add_option("--depths", options->depths, "depths to check (default 1-8)").type_name("LIST");
    sub.add_flag("--toggle", options->toggle,
                 "also check with each stage skipped and each setting changed, one at a "
                 "time");
    sub.add_option("--count", options->count, "number of scenes, each with the next seed").type_name("N");
    sub.add_option("--every", options->every, "process only every N-th frame").type_name("N");
    sub.add_option("--samples", options->samples, "number of bounds to check per frame (default 10)").type_name("N");
    add_catalogue_options(sub, options->scene);
    add_accuracy_options(sub, options->settings);
    sub.remove_option("--depth");
    sub.remove_option("--max-error");
    add_pipeline_options(sub, options->settings);
    sub.add_option("--csv", options->csv, "write one row per variant").type_name("FILE");
    sub.add_option("--json", options->json, "write the same as JSON").type_name("FILE");
    sub.footer("Examples:\n"
               "  oncollide accuracy paper --every 20\n"
               "  oncollide accuracy random --count 200 --frames 3 --depths 1-8 --toggle\n"
               "  oncollide accuracy hard                      (hard cases; see its own --help)\n"
               "  oncollide accuracy study paper --html study.html    (speed against error; see its own --help)\n"
               "Exit code 70: a collision was missed, a bound was broken, or a result changed unexpectedly.");
    sub.action([options] { return accuracy(*options); });
}

} // namespace oncollide::tools
