// oncollide-lab hard: checks every combination of stages on hard cases of collision detection, against exact
// arithmetic.
#include "commands/lab.hpp"

#include <algorithm>
#include <functional>
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
#include "verify/trials/differential.hpp"
#include "verify/trials/hard_trials.hpp"
#include "verify/trials/seeds.hpp"

namespace oncollide::tools {
namespace {

struct HardOptions {
    std::int64_t count = 100'000;
    std::vector<std::string> families;
    std::string data, csv, json, shard;
    int threads = 1;
};

/// A row of results, and what it takes to find it.
struct HardRow {
    std::string family; ///< as in --family
    std::function<Tally()> run;
};

Tally try_family(const std::string& family, const std::vector<BodyCase>& cases, int threads)
{
    std::vector<const BodyCase*> mine;
    for (const BodyCase& c : cases)
        if (c.family == family) mine.push_back(&c);
    const std::vector<Variant> variants = all_variants();
    return try_many(
        family, mine.size(), threads,
        [&](std::uint64_t number, Tally& tally) { tally += try_bodies(*mine[number], variants); }, 1);
}

/// Tests small scenes of all kinds of geometry, as `oncollide-lab fuzz` draws them.
Tally try_drawn(const std::string& family, std::uint64_t scenes, int threads)
{
    Tally tally{.family = family, .cases = scenes, .results = scenes};
    const FirstFault first = first_faulty_scene(1, scenes, threads, [] {});
    if (!first.what.empty())
        tally.fault(&Tally::wrong,
                    fmt::format("'oncollide-lab fuzz --seed {}' reduces it: {}", first.seed, first.what));
    return tally;
}

/// False if gl-compute cannot run here, with the reason at the terminal.
bool has_gpu()
try {
    Scene scene;
    scene.add_body({.name = "box", .geometry = scene.add("box", make_box_mesh({1, 1, 1}))});
    Pipeline(scene, {.backend = BackendKind::gl_compute});
    return true;
} catch (const Error& error) {
    if (error.kind() != ErrorKind::no_gpu) throw;
    say("skipped    gl-compute: {}\n", error.what());
    return false;
}

/// @param cases  must outlive the rows
std::vector<HardRow> all_rows(std::uint64_t count, int threads, const std::vector<BodyCase>& cases)
{
    const std::uint64_t tenth = (count + 9) / 10, fiftieth = (count + 49) / 50;
    std::vector<HardRow> rows;
    for (const TriangleFamily& family : triangle_families())
        for (const bool rotated : {false, true})
            rows.push_back({family.name, [=] { return try_triangles(family, count, rotated, threads); }});
    for (const NearFamily& family : near_families())
        rows.push_back({family.name, [=] { return try_bounds(family, tenth, threads); }});
    rows.push_back({approach_family, [=] { return try_approaches(tenth, threads); }});
    for (const BodyCase& c : cases)
        if (rows.back().family != c.family)
            rows.push_back({c.family, [=, &cases, name = c.family] { return try_family(name, cases, threads); }});
    for (const char* family : tangent_families)
        rows.push_back({family, [=] { return try_tangent(family, fiftieth, threads); }});
    for (const char* family : terrain_families)
        rows.push_back({family, [=] { return try_terrain(family, fiftieth, threads); }});
    const char* const drawn = "scenes with shapes and maps";
    rows.push_back({drawn, [=] { return try_drawn(drawn, fiftieth, threads); }});
    // Without the data folder's cases, which are too many.
    rows.push_back({"all of them at once", [] {
                        return try_crowd(surface_cases(), Mode::surface, std::vector<int>{1, 2, 3}, has_gpu());
                    }});
    rows.push_back({"all solids at once", [] {
                        return try_crowd(solid_cases(), Mode::solid, std::vector<int>{1, 3}, has_gpu());
                    }});
    return rows;
}

/// Keeps the rows of the requested families, and of these the shard's part.
void keep_chosen(std::vector<HardRow>& rows, const HardOptions& options)
{
    std::vector<std::string_view> known;
    for (const HardRow& row : rows)
        if (known.empty() || known.back() != row.family) known.push_back(row.family);
    for (const std::string& name : options.families)
        if (std::ranges::find(known, name) == known.end())
            usage(fmt::format("--family: unknown family '{}'{}", name, valid_names(name, known, "valid")));
    std::erase_if(rows, [&](const HardRow& row) {
        return !options.families.empty() && std::ranges::find(options.families, row.family) == options.families.end();
    });
    const auto [first, end] = shard_from(options.shard).range(rows.size());
    rows = std::vector(rows.begin() + std::ptrdiff_t(first), rows.begin() + std::ptrdiff_t(end));
}

/// Prints each row immediately, because the next one takes a while.
std::vector<Tally> try_all(const std::vector<HardRow>& rows)
{
    say("{:<34}", "family");
    for (const TallyCount& count : tally_counts) say("{:>{}}", count.title, count.width);
    say("\n");
    std::vector<Tally> tallies;
    for (const HardRow& row : rows) {
        const Tally& tally = tallies.emplace_back(row.run());
        say("{:<34}", tally.family);
        for (const TallyCount& count : tally_counts) say("{:>{}}", tally.*count.of, count.width);
        say("\n");
        if (!tally.first_fault.empty()) say("FAULT      {}\n", tally.first_fault);
        flush_stdout();
    }
    return tallies;
}

void write_csv(const std::string& path, const std::string& first_line, const std::vector<Tally>& rows)
{
    std::string header = "family";
    for (const TallyCount& count : tally_counts) header += fmt::format(",{}", count.name);
    CsvFile csv(path, header, first_line);
    for (const Tally& row : rows) {
        csv.rows().add(Quoted{row.family});
        for (const TallyCount& count : tally_counts) csv.rows().add(row.*count.of);
        csv.rows().end_row();
    }
    csv.commit();
}

void write_json(const std::string& path, const std::vector<Tally>& rows)
{
    OutputFile file(path);
    JsonWriter json(file);
    json.begin_object(), json.schema("oncollide.accuracy_hard", 2);
    json.key("header"), json.object("version", version);
    json.key("families"), json.begin_array();
    for (const Tally& row : rows) {
        json.line(2), json.begin_object(), json.members("family", row.family);
        for (const TallyCount& count : tally_counts) json.members(count.name, row.*count.of);
        json.end_object();
    }
    json.line(), json.end_array(), json.end_object();
    file.write("\n");
    file.commit();
}

int judge_hard_cases(HardOptions options)
{
    check_range("--count", options.count, 1), check_range("--threads", options.threads, 0);
    options.threads = threads_of(options.threads);
    check_files({{"--csv", options.csv}, {"--json", options.json}});
    std::vector<BodyCase> cases = body_cases();
    std::vector<BodyCase> queries = query_cases(data_folder(options.data));
    const bool no_queries = queries.empty();
    std::move(queries.begin(), queries.end(), std::back_inserter(cases));
    std::vector<HardRow> rows = all_rows(std::uint64_t(options.count), options.threads, cases);
    keep_chosen(rows, options);
    if (no_queries && options.families.empty())
        say("skipped    Erleben's spikes, wedges and internal edges: no data folder with queries/ (--data)\n");
    say("truth      exact integers for contacts, long double for distances; {} pairs of triangles per family,\n"
        "           bodies in 5 forms, {} combinations of stages\n{}\n",
        grouped(std::uint64_t(options.count)), all_variants().size(), describe_program("cpu"));
    const std::vector<Tally> tallies = try_all(rows);
    if (!options.csv.empty())
        write_csv(options.csv,
                  shard_from(options.shard)
                      .line(fmt::format("hard, count {}, families {}{}", options.count,
                                        options.families.empty() ? "all"
                                                                 : fmt::format("{}", fmt::join(options.families, ";")),
                                        no_queries ? ", without queries/" : "")),
                  tallies);
    if (!options.json.empty()) write_json(options.json, tallies);
    Tally sum;
    for (const Tally& tally : tallies) sum += tally;
    say("\n{}\n",
        sum.faults()
            ? fmt::format("{} VIOLATIONS", grouped(sum.faults()))
            : fmt::format("{} cases, {} results: no collision missed, no exact result wrong, no bound broken, no "
                          "unexpected change of a result",
                          grouped(sum.cases), grouped(sum.results)));
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
        "Pairs of triangles: the exact test, in both orders, is compared with linear programming in\n"
        "integers. Triangles that are near each other, and bodies of all kinds that approach\n"
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
        "  changed  results that differ although order or motion must not change them: must be 0\n\n"

        "Examples:\n"
        "  oncollide-lab hard --threads 0\n"
        "  oncollide-lab hard --count 1000 --family coplanar --family slivers --csv hard.csv\n"
        "For the catalogue's scene 'hard': oncollide scene hard --out hard.json, then oncollide accuracy hard.json.\n"
        "Exit code 70: a column that must be 0 is not.");
    sub.action([options] { return judge_hard_cases(*options); });
}

} // namespace oncollide::tools
