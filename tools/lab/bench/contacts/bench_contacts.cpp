// oncollide-lab bench contacts: contacts for a solver, in scenes that the reference solver plays, compared with other
// libraries at the same poses.
#include "bench/common/benchmark.hpp"
#include "bench/contacts/contact_play.hpp"
#include "bench/contacts/contact_race.hpp"
#include "cli/system.hpp"

#include <algorithm>
#include <cmath>

#include <oncollide/base/threads/parallel.hpp>

namespace oncollide::tools {
namespace {

struct ContactsOptions : SharedOptions {
    std::string scenes;
    ContactFiles files;
    int steps = 0, bodies = 0;
};

constexpr const char* played_mode = "played";

void add_rows(ResultTable& table, const ContactScene& scene, const std::string& mode, const PlayedScene& p,
              const std::vector<ContactRow>& rows)
{
    for (const ContactRow& row : rows)
        table.row(figures("scene", scene.name, "mode", mode, "who", row.name, "ms", row.ms, "contacts", row.contacts,
                          "of_oncollide", row.ms / rows.front().ms, "pairs", p.pairs, "regions", p.regions, "pairs_ms",
                          row.pairs_ms, "manifolds_ms", row.manifolds_ms, "first_ms", row.first_ms),
                  figures("most_points", p.most_points, "complete", p.complete, "step_ms", p.step_ms, "creep", p.creep,
                          "aside", p.aside, "speed", Digits{p.speed, 9}, "depth", p.depth, "lead", p.lead, "turns",
                          p.turns, "hash", Hex{p.hash}, "bodies", scene.bodies.size(), "what", scene.what));
}

/// The poses with the moving bodies a nanometre aside: a body that does not move would be found for nothing.
Poses nudged(const ContactScene& scene, Poses poses)
{
    for (std::size_t i = 0; i < poses.size(); ++i)
        if (!scene.bodies[i].half.isZero(0)) poses[i].translation().x() += 1e-9;
    return poses;
}

void describe(const ContactScene& scene, const PlayedScene& p)
{
    say("  {}; at most {} points a pair{}", scene.what, p.most_points, p.complete ? "" : ", a limit left some out");
    if (p.step_ms > 0)
        say("; a step with the solver {:.3f} ms; creep {:.2g} mm/s, depth {:.2g} mm", p.step_ms, 1e3 * p.creep,
            1e3 * p.depth);
    if (p.speed > 0) say("; {:.2g} mm/s aside, speed kept to {:.1g}", 1e3 * p.aside, std::abs(p.speed - 1));
    if (p.lead != 0) say("; {:.3f} mm a turn, {:.1f} turns", 1e3 * std::abs(p.lead), std::abs(p.turns));
    say("\n");
}

void write_contacts(const ContactsOptions& options, const ResultTable& table)
{
    OutputFile file(options.json);
    JsonWriter json(file);
    json.begin_object(), json.schema("oncollide.bench_contacts", 1);
    json.members("processor", processor_name(), "repeats", options.repeats, "threads", threads_of(options.threads));
    json.key("rows"), table.write(json, 1), json.end_object();
    file.write("\n"), file.commit();
}

int bench_contacts(const ContactsOptions& options)
{
    if (options.files.nut.empty() != options.files.bolt.empty())
        usage("bench contacts: --nut and --bolt are one scene; give both or none");
    ContactContenders contenders = all_contenders().contacts;
    if (options.only == "oncollide")
        contenders.all.clear();
    else
        contenders.keep(options.only);
    const std::vector<std::string> names = options.scenes.empty() ? std::vector<std::string>() : split(options.scenes);
    const std::vector<ContactEntry> scenes = contact_scenes(names, options.files, options.bodies);
    const int threads = threads_of(options.threads);
    say("{}detection at the same poses, {} thread{}; a step of oncollide is World::step() and manifolds()\n",
        describe_program("contacts"), threads, threads == 1 ? "" : "s");
    for (const ContactContender& c : contenders.all) say("{:<11}{}\n", c.name, c.what);
    print_missing(contenders.missing);
    say("\n");
    ResultTable table(options.csv, {25, 6, 11});
    bool moved = false;
    for (const ContactEntry& entry : scenes) {
        const ContactScene scene = entry.make();
        const bool all = options.steps == 0 || options.steps >= scene.steps;
        PlayedScene played = play(scene, all ? scene.steps : options.steps, threads);
        std::vector<ContactSteps> modes = scene.modes;
        if (modes.empty()) {
            if (played.poses.size() == 1) played.poses.push_back(nudged(scene, played.poses.front()));
            modes = {{played_mode, played.poses.front(), std::move(played.poses)}};
        }
        for (ContactSteps& mode : modes) {
            if (options.steps > 0) mode.steps.resize(std::min(mode.steps.size(), std::size_t(options.steps)));
            add_rows(table, scene, mode.mode, played, race(scene, mode, contenders, threads, options.repeats));
        }
        describe(scene, played);
        moved |= all && scene.most_creep > 0 && played.creep > scene.most_creep;
    }
    table.commit();
    if (!options.json.empty()) write_contacts(options, table);
    if (moved) say("\nA body that should rest moves faster than its scene allows.\n");
    return code_of(moved);
}

} // namespace

void add_contacts(Arguments bench)
{
    Benchmark<ContactsOptions> b(bench, "contacts",
                                 "Contacts for a solver: stacks, piles of shapes and of meshes, knots, a box that "
                                 "slides, a nut on a bolt, single pairs; compared with other libraries",
                                 bench_contacts);
    b->repeats = 5;
    b.option("--scene NAMES", b->scenes, "names, with commas between them (default: all)");
    b.input("--cow FILE", b->files.cow, "mesh of the second pile (default: generated)");
    b.input("--nut FILE", b->files.nut, "nut along z, in metres; adds a scene");
    b.input("--bolt FILE", b->files.bolt, "its bolt");
    b.option("--only NAMES", b->only, "other libraries, with commas between them; oncollide: none of them");
    b.repeats("runs over the recorded poses, of which the fastest counts");
    b.whole("--steps N", b->steps, "steps of each scene at most; 0: as many as it needs", {0});
    b.whole("--bodies N", b->bodies, "bodies of a scene of shapes, and single pairs; 0: as many as its name says", {0});
    b.threads("of oncollide");
    b.csv("scene, mode and library"), b.json("the same");
    b.footer("Scenes of meshes are played by a solver. Piles of shapes (pile-boxes-1000, ...) and shapes on the ground "
             "are timed in three modes: moving (2 mm a step), slow (0.1 mm a step) and at rest. A row of single "
             "pairs (pair-box-box, ...) is the mean of one pair.\n"
             "Exit code 70: a body that should rest moves.\n"
             "Example:\n"
             "  oncollide-lab bench contacts --scene stack-shapes,stack-1200 --json contacts.json");
}

} // namespace oncollide::tools
