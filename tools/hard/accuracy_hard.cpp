// oncollide accuracy hard: what collision detection gets wrong, by every combination of stages, held against
// exact arithmetic.
#include "cli/command.hpp"

#include <algorithm>
#include <exception>
#include <memory>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/near_word.hpp>
#include <oncollide/base/output_file.hpp>
#include <oncollide/base/parallel.hpp>
#include <oncollide/pipeline/pipeline.hpp>
#include <oncollide/scenes/model/mesh_generators.hpp>

#include "bench/bench.hpp"
#include "cli/shard.hpp"
#include "differential/differential.hpp"
#include "hard/body_trial.hpp"
#include "hard/crowd_trial.hpp"
#include "hard/tangent/tangent_trial.hpp"
#include "hard/tangent/terrain_trial.hpp"
#include "hard/triangle_trial.hpp"

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

/// The families that were requested.
class Choice {
public:
    Choice(const HardOptions& options, const std::vector<BodyCase>& cases) : chosen_(options.families)
    {
        for (const TriangleFamily& family : triangle_families()) known_.push_back(family.name);
        for (const std::string& name : families_of(cases)) known_.push_back(name);
        for (const char* name : tangent_families) known_.push_back(name);
        for (const char* name : terrain_families) known_.push_back(name);
        known_.push_back(drawn_family), known_.push_back(crowd_family), known_.push_back(solid_crowd_family);
        for (const std::string& name : chosen_)
            if (std::find(known_.begin(), known_.end(), name) == known_.end())
                usage(fmt::format("--family: no '{}'{}", name,
                                  valid_names(name, {known_.begin(), known_.end()}, "there are")));
        take_part(shard_from(options.shard));
    }
    bool operator()(const std::string& name) const
    {
        return chosen_.empty() || std::find(chosen_.begin(), chosen_.end(), name) != chosen_.end();
    }

private:
    /// A run of those chosen, in the order of the rows.
    void take_part(const Shard& shard)
    {
        if (shard.whole()) return;
        std::vector<std::string> all;
        for (const std::string& name : known_)
            if ((*this)(name)) all.push_back(name);
        const auto [first, end] = shard.range(all.size());
        chosen_.assign(all.begin() + std::ptrdiff_t(first), all.begin() + std::ptrdiff_t(end));
        if (chosen_.empty()) chosen_.push_back({}); // no family's name
    }

    std::vector<std::string> chosen_, known_;
};

/// Cases side by side; the sum does not depend on the number of threads.
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

/// Small scenes of all kinds of geometry, as `accuracy fuzz` draws them.
Tally try_drawn(std::uint64_t scenes, int threads)
{
    Tally tally{.family = drawn_family, .cases = scenes, .results = scenes};
    if (const auto seed = first_faulty_seed(1, scenes, threads, [] {}))
        tally.fault(&Tally::wrong, fmt::format("'oncollide accuracy fuzz --seed {0}' shrinks it: {1}", *seed,
                                               fault_in(draw_scene(*seed))));
    return tally;
}

/// Why gl-compute cannot run here; empty: it can.
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
    say("{:<34}{:>9}{:>11}{:>8}{:>7}{:>9}{:>9}{:>8}{:>9}{:>12}{:>11}\n", "family", "cases", "answers", "missed",
        "wrong", "false +", "bounds", "broken", "changed", "FCL missed", "FCL false");
}

/// At once, for the next takes a while.
void print_row(const Tally& t)
{
    say("{:<34}{:>9}{:>11}{:>8}{:>7}{:>9}{:>9}{:>8}{:>9}{:>12}{:>11}\n", t.family, t.cases, t.results, t.missed,
        t.wrong, t.false_positives, t.bounds, t.broken, t.changed, t.fcl_missed, t.fcl_false);
    if (!t.first_fault.empty()) say("FAULT      {}\n", t.first_fault);
    std::cout.flush();
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
            if (chosen(family.name)) add(try_triangles(family, std::uint64_t(options.count), rotated, options.threads));
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
    // Not the data folder's: they are too many.
    if (surfaces) add(try_crowd(surface_cases(), Mode::surface, std::vector<int>{1, 2, 3}, no_gpu.empty()));
    if (solids) add(try_crowd(solid_cases(), Mode::solid, std::vector<int>{1, 3}, no_gpu.empty()));
    return rows;
}

void write_csv(const std::string& path, const std::string& first_line, const std::vector<Tally>& rows)
{
    OutputFile file(path);
    file.write(first_line);
    file.print("family,cases,answers,missed,wrong,false_positives,bounds,bounds_broken,changed,fcl_missed,fcl_false\n");
    for (const Tally& t : rows)
        file.print("\"{}\",{},{},{},{},{},{},{},{},{},{}\n", t.family, t.cases, t.results, t.missed, t.wrong,
                   t.false_positives, t.bounds, t.broken, t.changed, t.fcl_missed, t.fcl_false);
    file.commit();
}

void write_json(const std::string& path, const std::vector<Tally>& rows)
{
    OutputFile file(path);
    file.print("{{\"header\": {{\"version\": \"{}\"}}, \"families\": [", version);
    for (const Tally& t : rows)
        file.print(
            "{}\n  {{\"family\": \"{}\", \"cases\": {}, \"answers\": {}, \"missed\": {}, \"wrong\": {}, "
            "\"false_positives\": {}, \"bounds\": {}, \"bounds_broken\": {}, \"changed\": {}, \"fcl_missed\": {}, "
            "\"fcl_false\": {}}}",
            &t == rows.data() ? "" : ",", t.family, t.cases, t.results, t.missed, t.wrong, t.false_positives, t.bounds,
            t.broken, t.changed, t.fcl_missed, t.fcl_false);
    file.print("\n]}}\n");
    file.commit();
}

int accuracy_hard(HardOptions options)
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
    say("truth      exact integers for what meets, long double for distances; {} pairs of triangles a family,\n"
        "           bodies in 5 forms and {} combinations of stages\n{}\n",
        grouped(std::uint64_t(options.count)), all_variants().size(), describe_program("cpu"));
    const std::vector<Tally> rows = try_all(options, chosen, cases);
    if (!options.csv.empty())
        write_csv(options.csv,
                  shard_from(options.shard)
                      .line(fmt::format("accuracy hard, count {}, families {}{}", options.count,
                                        options.families.empty() ? "all"
                                                                 : fmt::format("{}", fmt::join(options.families, ";")),
                                        no_queries ? ", without queries/" : "")),
                  rows);
    if (!options.json.empty()) write_json(options.json, rows);
    Tally sum;
    for (const Tally& row : rows) sum += row;
    say("\n{}; FCL misses {} collisions and invents {}\n",
        sum.faults()
            ? fmt::format("{} VIOLATIONS", grouped(sum.faults()))
            : fmt::format("{} cases, {} answers: no collision missed, no exact answer wrong, no bound broken, none "
                          "changed that must not",
                          grouped(sum.cases), grouped(sum.results)),
        grouped(sum.fcl_missed), grouped(sum.fcl_false));
    return sum.faults() ? int(ErrorKind::internal) : 0;
}

} // namespace

void add_accuracy_hard(Arguments accuracy)
{
    Arguments sub = accuracy.add_command("hard", "Check every stage on what is hard: touching, coplanar, thin, "
                                                 "tiny, huge, far and inside, against exact arithmetic");
    auto options = std::make_shared<HardOptions>();
    sub.add_option("--count", options->count,
                   "pairs of triangles a family, as stored and again turned (default 100000)")
        .type_name("N");
    sub.add_option("--family", options->families, "this family alone (repeatable); a wrong name lists them")
        .type_name("NAME")
        .repeatable();
    sub.add_option("--threads", options->threads, "threads; 0: all. Never changes the result (default 1)")
        .type_name("N");
    sub.add_option("--data", options->data,
                   "folder with queries/, Erleben's cases (default: $ONCOLLIDE_DATA, else ../shared/data if present)")
        .type_name("DIR");
    sub.add_option("--csv", options->csv, "write one row a family").type_name("FILE");
    sub.add_option("--shard", options->shard, std::string("of the families, ") + shard_help).type_name("I/N");
    sub.add_option("--json", options->json, "write the same as JSON").type_name("FILE");
    sub.footer(
        "Pairs of triangles: the exact test, in both orders, and FCL's, against linear programming in integers.\n"
        "Spheres, capsules and triangles that touch cells, boxes, hulls and meshes, or just do not, and all of these "
        "on\n"
        "terrains: squares of integers.\n"
        "Bodies: every set of stages left out, both kinds of spheres, each exact level, budgets; as stored, swapped, "
        "with\n"
        "triangles and corners in another order, turned by a quarter, and turned anyhow and so rounded. With "
        "clearances "
        "below,\n"
        "at and above the distance; as solids; and with kinds of contact. Then all at once, for several numbers of "
        "threads\n"
        "and on a GPU where there is one.\n\n"
        "Columns:\n"
        "  missed   collisions, or bodies within the clearance, that a result lost: must be 0\n"
        "  wrong    exact results that invent a collision, leave it open or name the wrong kind: must be 0\n"
        "  false +  'within' for bodies that do not collide: allowed without an exact level\n"
        "  broken   certified bounds that the true distance contradicts: must be 0\n"
        "  changed  results that the order or a motion changed and must not: must be 0\n"
        "  FCL      cases in which FCL's own test misses a collision, or invents one\n\n"
        "Examples:\n"
        "  oncollide accuracy hard --threads 0\n"
        "  oncollide accuracy hard --count 1000 --family coplanar --family slivers --csv hard.csv\n"
        "The catalogue's scene of this name: oncollide scene hard --out hard.json, then oncollide accuracy hard.json.\n"
        "Exit code 70: something is not 0 that must be.");
    sub.action([options] { return accuracy_hard(*options); });
}

} // namespace oncollide::tools
