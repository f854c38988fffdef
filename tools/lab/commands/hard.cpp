// oncollide-lab hard: checks every combination of stages on hard cases of collision detection, against exact
// arithmetic.
#include "commands/lab.hpp"

#include <algorithm>
#include <exception>
#include <memory>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/generators.hpp>

#include "cli/shard.hpp"
#include "cli/standard_output.hpp"
#include "common/text.hpp"
#include "fcl/fcl_pair.hpp"
#include "verify/trials/approach_trial.hpp"
#include "verify/trials/body_trial.hpp"
#include "verify/trials/bound_trial.hpp"
#include "verify/trials/crowd_trial.hpp"
#include "verify/trials/differential.hpp"
#include "verify/trials/tangent_trial.hpp"
#include "verify/trials/terrain_trial.hpp"
#include "verify/trials/triangle_trial.hpp"

namespace oncollide::tools {
namespace {

struct HardOptions {
    std::int64_t count = 100'000;
    std::vector<std::string> families;
    std::string data, csv, json, shard;
    int threads = 1;
};

constexpr const char *crowd_family = "all of them at once", *solid_crowd_family = "all solids at once",
                     *drawn_family = "scenes with shapes and maps";

/// Names in the order of their first appearance.
std::vector<std::string> families_of(const std::vector<BodyCase>& cases)
{
    std::vector<std::string> names;
    for (const BodyCase& c : cases)
        if (names.empty() || names.back() != c.family) names.push_back(c.family);
    return names;
}

/// The requested families.
class Choice {
public:
    Choice(const HardOptions& options, const std::vector<BodyCase>& cases) : chosen_(options.families)
    {
        for (const TriangleFamily& family : triangle_families()) known_.push_back(family.name);
        for (const NearFamily& family : near_families()) known_.push_back(family.name);
        known_.push_back(approach_family);
        for (const std::string& name : families_of(cases)) known_.push_back(name);
        for (const char* name : tangent_families) known_.push_back(name);
        for (const char* name : terrain_families) known_.push_back(name);
        known_.push_back(drawn_family), known_.push_back(crowd_family), known_.push_back(solid_crowd_family);
        for (const std::string& name : chosen_)
            if (std::find(known_.begin(), known_.end(), name) == known_.end())
                usage(fmt::format("--family: unknown family '{}'{}", name,
                                  valid_names(name, {known_.begin(), known_.end()}, "valid")));
        take_part(shard_from(options.shard));
    }
    bool operator()(const std::string& name) const
    {
        return chosen_.empty() || std::find(chosen_.begin(), chosen_.end(), name) != chosen_.end();
    }

private:
    /// Keeps a contiguous part of the chosen families, in the order of the rows.
    void take_part(const Shard& shard)
    {
        if (shard.whole()) return;
        std::vector<std::string> all;
        for (const std::string& name : known_)
            if ((*this)(name)) all.push_back(name);
        const auto [first, end] = shard.range(all.size());
        chosen_.assign(all.begin() + std::ptrdiff_t(first), all.begin() + std::ptrdiff_t(end));
        if (chosen_.empty()) chosen_.push_back({}); // "" is not a family's name, so nothing matches
    }

    std::vector<std::string> chosen_, known_;
};

/// Tests cases in parallel; the sum does not depend on the number of threads.
Tally try_family(const std::string& family, const std::vector<BodyCase>& cases, int threads)
{
    std::vector<const BodyCase*> mine;
    for (const BodyCase& c : cases)
        if (c.family == family) mine.push_back(&c);
    const std::vector<Variant> variants = all_variants();
    std::vector<Tally> tallies(mine.size());
    std::vector<std::exception_ptr> errors(mine.size());
    parallel_chunks(mine.size(), 1, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t k = begin; k < end; ++k) try {
                tallies[k] = try_bodies(*mine[k], variants);
            } catch (...) {
                errors[k] = std::current_exception();
            }
    });
    for (const std::exception_ptr& error : errors)
        if (error) std::rethrow_exception(error);
    Tally sum{.family = family};
    for (const Tally& tally : tallies) sum += tally;
    return sum;
}

/// Tests small scenes of all kinds of geometry, as `oncollide-lab fuzz` draws them.
Tally try_drawn(std::uint64_t scenes, int threads)
{
    Tally tally{.family = drawn_family, .cases = scenes, .results = scenes};
    if (const auto seed = first_faulty_seed(1, scenes, threads, [] {}))
        tally.fault(&Tally::wrong,
                    fmt::format("'oncollide-lab fuzz --seed {0}' reduces it: {1}", *seed, fault_in(draw_scene(*seed))));
    return tally;
}

/// The reason why gl-compute cannot run here; empty if it can.
std::string why_no_gpu()
{
    Scene scene;
    scene.add_body({.name = "box", .geometry = scene.add("box", make_box_mesh({1, 1, 1}))});
    try {
        Pipeline(scene, {.backend = BackendKind::gl_compute});
        return {};
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::no_gpu) throw;
        return error.what();
    }
}

void print_header()
{
    say("{:<34}{:>9}{:>11}{:>8}{:>7}{:>9}{:>9}{:>8}{:>9}{:>12}{:>11}\n", "family", "cases", "results", "missed",
        "wrong", "false +", "bounds", "broken", "changed", "FCL missed", "FCL false");
}

/// Prints a row immediately, because the next one takes a while.
void print_row(const Tally& t)
{
    say("{:<34}{:>9}{:>11}{:>8}{:>7}{:>9}{:>9}{:>8}{:>9}{:>12}{:>11}\n", t.family, t.cases, t.results, t.missed,
        t.wrong, t.false_positives, t.bounds, t.broken, t.changed, t.fcl_missed, t.fcl_false);
    if (!t.first_fault.empty()) say("FAULT      {}\n", t.first_fault);
    flush_stdout();
}

std::vector<Tally> try_all(const HardOptions& options, const Choice& chosen, const std::vector<BodyCase>& cases)
{
    std::vector<Tally> rows;
    const auto add = [&](Tally row) {
        print_row(row);
        rows.push_back(std::move(row));
    };
    print_header();
    for (const TriangleFamily& family : triangle_families())
        for (bool rotated : {false, true})
            if (chosen(family.name))
                add(try_triangles(family, std::uint64_t(options.count), rotated, options.threads, fcl_triangles_meet));
    for (const NearFamily& family : near_families())
        if (chosen(family.name)) add(try_bounds(family, std::uint64_t(options.count + 9) / 10, options.threads));
    if (chosen(approach_family)) add(try_approaches(std::uint64_t(options.count + 9) / 10, options.threads));
    for (const std::string& family : families_of(cases))
        if (chosen(family)) add(try_family(family, cases, options.threads));
    for (const char* family : tangent_families)
        if (chosen(family)) add(try_tangent(family, std::uint64_t(options.count + 49) / 50, options.threads));
    for (const char* family : terrain_families)
        if (chosen(family)) add(try_terrain(family, std::uint64_t(options.count + 49) / 50, options.threads));
    if (chosen(drawn_family)) add(try_drawn(std::uint64_t(options.count + 49) / 50, options.threads));
    const bool surfaces = chosen(crowd_family), solids = chosen(solid_crowd_family);
    if (!surfaces && !solids) return rows;
    const std::string no_gpu = why_no_gpu();
    if (!no_gpu.empty()) say("skipped    gl-compute: {}\n", no_gpu);
    // Without the data folder's cases, which are too many.
    if (surfaces) add(try_crowd(surface_cases(), Mode::surface, std::vector<int>{1, 2, 3}, no_gpu.empty()));
    if (solids) add(try_crowd(solid_cases(), Mode::solid, std::vector<int>{1, 3}, no_gpu.empty()));
    return rows;
}

void write_csv(const std::string& path, const std::string& first_line, const std::vector<Tally>& rows)
{
    CsvFile csv(path,
                "family,cases,answers,missed,wrong,false_positives,bounds,bounds_broken,changed,fcl_missed,fcl_false",
                first_line);
    for (const Tally& t : rows)
        csv.row(Quoted{t.family}, t.cases, t.results, t.missed, t.wrong, t.false_positives, t.bounds, t.broken,
                t.changed, t.fcl_missed, t.fcl_false);
    csv.commit();
}

void write_json(const std::string& path, const std::vector<Tally>& rows)
{
    OutputFile file(path);
    JsonWriter json(file);
    json.begin_object(), json.schema("oncollide.accuracy_hard", 1);
    json.key("header"), json.object("version", version);
    json.key("families"), json.begin_array();
    for (const Tally& t : rows) {
        json.line(2);
        json.object("family", t.family, "cases", t.cases, "answers", t.results, "missed", t.missed, "wrong", t.wrong,
                    "false_positives", t.false_positives, "bounds", t.bounds, "bounds_broken", t.broken, "changed",
                    t.changed, "fcl_missed", t.fcl_missed, "fcl_false", t.fcl_false);
    }
    json.line(), json.end_array();
    json.end_object();
    file.write("\n");
    file.commit();
}

int judge_hard_cases(HardOptions options)
{
    check_range("--count", options.count, 1), check_range("--threads", options.threads, 0);
    if (options.threads == 0) options.threads = hardware_threads();
    check_files({{"--csv", options.csv}, {"--json", options.json}});
    std::vector<BodyCase> cases = body_cases();
    std::vector<BodyCase> queries = query_cases(data_folder(options.data));
    const bool no_queries = queries.empty();
    std::move(queries.begin(), queries.end(), std::back_inserter(cases));
    const Choice chosen(options, cases);
    if (no_queries && options.families.empty())
        say("skipped    Erleben's spikes, wedges and internal edges: no data folder with queries/ (--data)\n");
    say("truth      exact integers for contacts, long double for distances; {} pairs of triangles per family,\n"
        "           bodies in 5 forms, {} combinations of stages\n{}\n",
        grouped(std::uint64_t(options.count)), all_variants().size(), describe_program("cpu"));
    const std::vector<Tally> rows = try_all(options, chosen, cases);
    write_csv(
        options.csv,
        shard_from(options.shard)
            .line(fmt::format("hard, count {}, families {}{}", options.count,
                              options.families.empty() ? "all" : fmt::format("{}", fmt::join(options.families, ";")),
                              no_queries ? ", without queries/" : "")),
        rows);
    if (!options.json.empty()) write_json(options.json, rows);
    Tally sum;
    for (const Tally& row : rows) sum += row;
    say("\n{}; FCL misses {} collisions and reports {} false ones\n",
        sum.faults()
            ? fmt::format("{} VIOLATIONS", grouped(sum.faults()))
            : fmt::format("{} cases, {} results: no collision missed, no exact result wrong, no bound broken, no "
                          "unexpected change of a result",
                          grouped(sum.cases), grouped(sum.results)),
        grouped(sum.fcl_missed), grouped(sum.fcl_false));
    return sum.faults() ? int(ErrorKind::internal) : 0;
}

} // namespace

void add_hard(Arguments app)
{
    Arguments sub = app.add_command("hard", "Check every stage on hard cases against exact arithmetic: touching, "
                                            "coplanar, thin, tiny, huge, far from the origin, enclosed");
    auto options = std::make_shared<HardOptions>();
    sub.add_option("--count N", options->count,
                   "pairs of triangles per family, tested as stored and again rotated (default 100000)");
    sub.add_option("--family NAME", options->families,
                   "test only this family (repeatable); an unknown name lists all families")
        .repeatable();
    sub.add_option("--threads N", options->threads,
                   "number of threads; 0: all. Does not change the result (default 1)");
    sub.add_option("--data DIR", options->data,
                   "folder with queries/, Erleben's cases (default: $ONCOLLIDE_DATA, else ../shared/data if present)");
    sub.add_option("--csv FILE", options->csv, "write one row per family");
    sub.add_option("--shard I/N", options->shard, std::string("divide the families among N processes: ") + shard_help);
    sub.add_option("--json FILE", options->json, "write the same as JSON");
    sub.footer(
        "Pairs of triangles: the exact test, in both orders, and FCL's test are compared with linear\n"
        "programming in integers. Triangles that are near each other, and bodies of all kinds that approach\n"
        "each other, a tenth as many: every bound on the distance of triangles is compared with rational\n"
        "arithmetic, and a World that lives through small moves with new decisions. Spheres, capsules and\n"
        "triangles that touch cells, boxes, hulls, meshes or terrains, or barely miss them: the truth is\n"
        "computed from squares of integers. Bodies: with each set of stages skipped, both bounding volumes,\n"
        "each exact level and budgets; as stored, swapped, with triangles and vertices in another order,\n"
        "rotated by quarter turns, and moved with rounding; with clearances below, at and above the distance;\n"
        "as solids; and with kinds of contact. Finally all cases in one scene, with several numbers of\n"
        "threads, and on a GPU if there is one.\n\n"
        "Columns:\n"
        "  missed   collisions, or bodies within the clearance, that a result does not report: must be 0\n"
        "  wrong    exact results with a false collision, without a decision or with the wrong kind: must be 0\n"
        "  false +  'within' for bodies that do not collide: allowed without an exact level\n"
        "  broken   certified bounds that the true distance contradicts: must be 0\n"
        "  changed  results that differ although order or motion must not change them: must be 0\n"
        "  FCL      cases in which FCL's own test misses a collision, or reports a false one\n\n"
        "Examples:\n"
        "  oncollide-lab hard --threads 0\n"
        "  oncollide-lab hard --count 1000 --family coplanar --family slivers --csv hard.csv\n"
        "For the catalogue's scene 'hard': oncollide scene hard --out hard.json, then oncollide accuracy hard.json.\n"
        "Exit code 70: a column that must be 0 is not.");
    sub.action([options] { return judge_hard_cases(*options); });
}

} // namespace oncollide::tools
