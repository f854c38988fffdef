// oncollide-lab bench contacts: contacts for a solver, in scenes that the reference solver plays, compared with other
// libraries at the same poses.
#include "bench/common/benchmark.hpp"
#include "bench/contacts/contact_scenes.hpp"
#include "cli/system.hpp"
#include "peers/peers.hpp"

#include <algorithm>
#include <map>
#include <memory>

#include <oncollide/samples/impulse_solver.hpp>

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Poses = std::vector<Isometry3d>;

struct ContactsOptions : SharedOptions {
    std::string scenes;
    ContactFiles files;
    int steps = 0;
};

/// The run of a scene in the reference solver.
struct Played {
    std::vector<Poses> poses; ///< of all bodies, in each timed step
    double step_ms = 0;       ///< of the solver and the World together, median of the timed steps
    double creep = 0;         ///< greatest displacement of a body in the timed steps, over their time, m/s
    double aside = 0;         ///< greatest speed of the first moving body across the speed that it began with, m/s
    double speed = 0;         ///< its speed along that, as a share
    double depth = 0;         ///< greatest depth in the timed steps, m
    double lead = 0;          ///< of the first moving body: way along z per turn around it, m
    double turns = 0;
    std::size_t pairs = 0, regions = 0, points = 0, most_points = 0; ///< last step; most_points: of a pair
    bool complete = true;
    std::uint64_t hash = 0; ///< of the last step's manifolds
};

/// One line of the table.
struct ContactRow {
    std::string name;
    double ms = 0; ///< of a step's detection
    double contacts = 0;
};

class OurContacts {
public:
    OurContacts(const ContactScene& scene, int threads)
        : world_({.clearance = scene.margin, .threads = threads}), margin_(scene.margin)
    {
        std::map<const Geometry*, ModelId> models;
        for (const ContactBody& body : scene.bodies) {
            auto [at, added] = models.emplace(body.geometry.get(), ModelId{});
            if (added) at->second = world_.models().add(body.geometry);
            const bool is_static = body.half.isZero(0);
            ids_.push_back(world_.bodies().add({.model = at->second, .pose = body.pose, .is_static = is_static}));
        }
    }
    std::size_t contacts(const Poses& poses)
    {
        for (std::size_t i = 0; i < ids_.size(); ++i) world_.bodies().set_pose(ids_[i], poses[i]);
        pairs_.clear();
        for (const PairResult& pair : world_.step().pairs) pairs_.push_back({pair.a, pair.b});
        world_.pairs().manifold(pairs_, {.margin = margin_}, lists_);
        return lists_.points.size();
    }
    World& world() { return world_; }
    const std::vector<BodyId>& ids() const { return ids_; }

private:
    World world_;
    double margin_;
    std::vector<BodyId> ids_;
    std::vector<PairOfBodies> pairs_;
    ManifoldLists lists_;
};

/// How a body has turned around z from one pose to the next.
double turn_between(const Isometry3d& from, const Isometry3d& to)
{
    const Eigen::Matrix3d turned = to.linear() * from.linear().transpose();
    return std::atan2(turned(1, 0) - turned(0, 1), turned(0, 0) + turned(1, 1));
}

void add_manifolds(Played& played, const ManifoldLists& lists)
{
    played.pairs = lists.complete.size(), played.regions = lists.regions.size(), played.points = lists.points.size();
    for (std::size_t i = 0; i < played.pairs; ++i) {
        std::size_t points = 0;
        for (std::size_t k = lists.offsets[i]; k < lists.offsets[i + 1]; ++k) points += lists.regions[k].count;
        played.most_points = std::max(played.most_points, points);
        played.complete = played.complete && lists.complete[i];
    }
    for (const ManifoldRegion& r : lists.regions) played.depth = std::max(played.depth, r.depth_lower);
    played.hash = hash_of(lists);
}

Played play(const ContactScene& scene, int steps, int threads)
{
    OurContacts ours(scene, threads);
    World& world = ours.world();
    example::ImpulseSolver solver(world);
    solver.dt = scene.dt, solver.friction = scene.friction, solver.margin = scene.margin, solver.slop = scene.slop;
    std::size_t first = scene.bodies.size(); // that moves
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const ContactBody& body = scene.bodies[i];
        const bool moves = !body.half.isZero(0);
        if (moves) first = std::min(first, i);
        solver.bodies.push_back(moves ? example::box_body(ours.ids()[i], body.half)
                                      : example::RigidBody{.id = ours.ids()[i]});
        solver.bodies.back().velocity = body.velocity;
    }
    const auto poses = [&] {
        Poses all;
        for (const BodyId id : ours.ids()) all.push_back(world.bodies().pose(id));
        return all;
    };
    Played played;
    if (steps == 0) { // as they are
        played.poses.push_back(poses());
        std::vector<PairOfBodies> pairs;
        for (const PairResult& pair : world.step().pairs) pairs.push_back({pair.a, pair.b});
        ManifoldLists lists;
        world.pairs().manifold(pairs, {.margin = scene.margin}, lists);
        add_manifolds(played, lists);
        return played;
    }
    const Vector3d along = scene.bodies[first].velocity;
    Isometry3d before = world.bodies().pose(ours.ids()[first]), after_half = before;
    std::vector<double> step_ms;
    for (int i = 0; i < steps; ++i) {
        if (i >= steps - scene.timed) played.poses.push_back(poses());
        const double ms = least_ms(1, [&] { solver.step(); });
        if (i >= steps - scene.timed) step_ms.push_back(ms), add_manifolds(played, solver.manifolds());
        const Isometry3d now = world.bodies().pose(ours.ids()[first]);
        const double turn = turn_between(before, now) / (2 * M_PI);
        if (std::abs(played.turns) < 0.5 && std::abs(played.turns + turn) >= 0.5) after_half = now;
        played.turns += turn, before = now;
        if (!along.isZero(0) && i >= steps / 10) {
            const Vector3d& v = solver.bodies[first].velocity;
            played.speed = v.dot(along) / along.squaredNorm();
            played.aside = std::max(played.aside, (v - played.speed * along).norm());
        }
    }
    played.step_ms = median(step_ms);
    if (std::abs(played.turns) > 1)
        played.lead = (before.translation().z() - after_half.translation().z()) / (std::abs(played.turns) - 0.5);
    const double time = scene.dt * double(played.poses.size());
    for (std::size_t i = 0; i < ours.ids().size(); ++i) {
        const Vector3d way = world.bodies().pose(ours.ids()[i]).translation() - played.poses.front()[i].translation();
        played.creep = std::max(played.creep, way.norm() / time);
    }
    return played;
}

/// Detection at the recorded poses, all contenders in turns.
std::vector<ContactRow> race(const ContactScene& scene, const Played& played, const ContactContenders& contenders,
                             const ContactsOptions& options)
{
    std::vector<ContactPeerBody> bodies;
    for (const ContactBody& body : scene.bodies) bodies.push_back({body.geometry.get(), body.half.isZero(0)});
    OurContacts ours(scene, options.threads);
    std::vector<ContactRow> rows = {{"oncollide"}};
    std::vector<std::unique_ptr<ContactPeer>> peers;
    for (const ContactContender& c : contenders.all) rows.push_back({c.name}), peers.push_back(c.make(bodies));
    const std::size_t count = played.poses.size();
    std::vector<std::vector<double>> least(rows.size(), std::vector<double>(count, 1e300)); // of each pose
    for (int repeat = -1; repeat < options.repeats; ++repeat) // trees grow in the first, which does not count
        take_turns(rows.size(), static_cast<std::size_t>(repeat + 1), [&](std::size_t who) {
            rows[who].contacts = 0;
            for (std::size_t i = 0; i < count; ++i) {
                const auto find = [&] {
                    const Poses& poses = played.poses[i];
                    rows[who].contacts += double(who == 0 ? ours.contacts(poses) : peers[who - 1]->contacts(poses));
                };
                const double ms = least_ms(1, find);
                if (repeat >= 0) least[who][i] = std::min(least[who][i], ms);
            }
        });
    for (std::size_t who = 0; who < rows.size(); ++who)
        rows[who].ms = mean(least[who]), rows[who].contacts /= double(count);
    return rows;
}

void report(ResultTable& table, const ContactScene& scene, const Played& p, const std::vector<ContactRow>& rows)
{
    for (const ContactRow& row : rows)
        table.row(figures("scene", scene.name, "who", row.name, "ms", row.ms, "contacts", row.contacts, "of_oncollide",
                          row.ms / rows.front().ms, "pairs", p.pairs, "regions", p.regions),
                  figures("most_points", p.most_points, "complete", p.complete, "step_ms", p.step_ms, "creep", p.creep,
                          "aside", p.aside, "speed", Digits{p.speed, 9}, "depth", p.depth, "lead", p.lead, "turns",
                          p.turns, "hash", Hex{p.hash}, "what", scene.what));
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
    json.members("processor", processor_name(), "repeats", options.repeats, "threads", options.threads);
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
    const std::vector<ContactScene> scenes = contact_scenes(names, options.files);
    say("{}detection at the same poses, {} thread{}; a step of oncollide is World::step() and manifolds()\n",
        describe_program("contacts"), options.threads, options.threads == 1 ? "" : "s");
    for (const ContactContender& c : contenders.all) say("{:<11}{}\n", c.name, c.what);
    print_missing(contenders.missing);
    say("\n");
    ResultTable table(options.csv, {16, 11});
    bool moved = false;
    for (const ContactScene& scene : scenes) {
        const bool all = options.steps == 0 || options.steps >= scene.steps;
        const Played played = play(scene, all ? scene.steps : options.steps, options.threads);
        report(table, scene, played, race(scene, played, contenders, options));
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
                                 "Contacts for a solver: stacks, piles, knots, a box that slides, a nut on a bolt; "
                                 "compared with other libraries",
                                 bench_contacts);
    b->repeats = 5;
    b.option("--scene NAMES", b->scenes, "names, with commas between them (default: all)");
    b.input("--cow FILE", b->files.cow, "mesh of the second pile (default: generated)");
    b.input("--nut FILE", b->files.nut, "nut along z, in metres; adds a scene");
    b.input("--bolt FILE", b->files.bolt, "its bolt");
    b.option("--only NAMES", b->only, "other libraries, with commas between them; oncollide: none of them");
    b.repeats("runs over the recorded poses, of which the fastest counts");
    b.whole("--steps N", b->steps, "steps of each scene at most; 0: as many as it needs", {0});
    b.whole("--threads N", b->threads, "of oncollide", {1, 256});
    b.csv("scene and library"), b.json("the same");
    b.footer("Exit code 70: a body that should rest moves.\n"
             "Example:\n"
             "  oncollide-lab bench contacts --scene stack-shapes,stack-1200 --json contacts.json");
}

} // namespace oncollide::tools
