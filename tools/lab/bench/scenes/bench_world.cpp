// oncollide-lab bench world: cost of a frame by the number of bodies added, removed or moved, and cost of queries.
#include "bench/bench.hpp"
#include "cli/options.hpp"
#include "cli/system.hpp"
#include "common/statistics.hpp"
#include "common/text.hpp"

#include <algorithm>
#include <memory>
#include <numeric>
#include <set>
#include <thread>
#include <tuple>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/catalogue.hpp>

namespace oncollide::tools {
namespace {

struct WorldOptions {
    int bodies = 100'000;
    int changes = 1000; ///< bodies that move, or are removed and added, per frame
    int frames = 20;
    std::uint64_t seed = 12345;
    Settings settings;
    std::string csv;
};

/// The bodies of the catalogue's scene `many` in a World. Each body's user number is its index in the list.
class Crowd {
public:
    Crowd(const WorldOptions& options, std::uint32_t bodies)
        : scene_(make_scene("many", {.bodies = bodies, .frames = {}, .seed = options.seed, .data = {}})),
          world_(options.settings)
    {
        models_ = add_models(world_);
        std::vector<BodySpec> specs;
        for (std::size_t i = 0; i < scene_.size(); ++i) specs.push_back(spec_of(models_, i));
        ids_.resize(specs.size());
        world_.bodies().add(specs, ids_);
    }

    World& world() { return world_; }
    std::size_t size() const { return ids_.size(); }

    /// Moves `count` bodies, different bodies each time, each to the start pose of another.
    void move(std::size_t count)
    {
        some_ids_.clear(), some_poses_.clear();
        for (const std::size_t i : pick(count)) {
            some_ids_.push_back(ids_[i]);
            some_poses_.push_back(scene_.poses[place()]);
        }
        world_.bodies().set_pose(some_ids_, some_poses_);
    }

    /// Removes `count` bodies and adds as many at other poses.
    void exchange(std::size_t count)
    {
        const std::vector<std::size_t> chosen = pick(count);
        some_ids_.clear(), some_specs_.clear();
        for (const std::size_t i : chosen) {
            some_ids_.push_back(ids_[i]);
            some_specs_.push_back(spec_of(models_, i));
            some_specs_.back().pose = scene_.poses[place()];
        }
        world_.bodies().remove(some_ids_);
        world_.bodies().add(some_specs_, some_ids_);
        for (std::size_t k = 0; k < chosen.size(); ++k) ids_[chosen[k]] = some_ids_[k];
    }

    /// The pairs that are not separate, by the bodies' indices in the list.
    using Pairs = std::set<std::tuple<std::uint64_t, std::uint64_t, Verdict>>;
    static Pairs pairs(World& world)
    {
        Pairs found;
        for (const PairResult& pair : world.step().pairs) {
            if (pair.verdict == Verdict::separate) continue;
            const auto [a, b] = std::minmax({world.bodies().user(pair.a), world.bodies().user(pair.b)});
            found.insert({a, b, pair.verdict});
        }
        return found;
    }

    /// True if a newly made World finds the same pairs.
    bool is_as_made_anew()
    {
        World fresh(world_.settings());
        const std::vector<ModelId> models = add_models(fresh);
        for (std::size_t i = 0; i < ids_.size(); ++i) {
            BodySpec spec = spec_of(models, i);
            spec.pose = world_.bodies().pose(ids_[i]);
            fresh.bodies().add(spec);
        }
        return pairs(world_) == pairs(fresh);
    }

    /// Queries of the first bodies' models at the poses of others.
    std::vector<PlacedModel> queries(std::size_t count)
    {
        std::vector<PlacedModel> queries;
        for (std::size_t i = 0; i < count; ++i)
            queries.push_back({models_[index(scene_.geometry[i % size()])], scene_.poses[place()]});
        return queries;
    }

private:
    /// The models of the scene's geometries, by number.
    std::vector<ModelId> add_models(World& world) const
    {
        std::vector<ModelId> models;
        for (std::size_t g = 0; g < scene_.geometries.size(); ++g)
            models.push_back(world.models().add(scene_.geometries.share(g)));
        return models;
    }
    BodySpec spec_of(std::span<const ModelId> models, std::size_t i) const
    {
        return {.model = models[index(scene_.geometry[i])], .pose = scene_.poses[i], .user = i};
    }
    std::size_t place() { return std::size_t(u01(7, draws_++, 0) * double(size())); }
    /// The next `count` bodies in rotation.
    std::vector<std::size_t> pick(std::size_t count)
    {
        std::vector<std::size_t> chosen(count);
        std::iota(chosen.begin(), chosen.end(), next_);
        next_ = (next_ + count) % size();
        for (std::size_t& i : chosen) i %= size();
        return chosen;
    }

    Scene scene_;
    World world_;
    std::vector<ModelId> models_;
    std::vector<BodyId> ids_, some_ids_;
    std::vector<Eigen::Isometry3d> some_poses_;
    std::vector<BodySpec> some_specs_;
    std::size_t next_ = 0;
    std::uint64_t draws_ = 0;
};

/// Median milliseconds per frame: of the calls that change bodies, and of step().
template <class Change>
std::pair<double, double> time_frames(Crowd& crowd, int frames, Change change)
{
    std::vector<double> changes, steps;
    for (int frame = -3; frame < frames; ++frame) {
        const auto begin = Clock::now();
        change();
        const double changed = milliseconds_since(begin);
        crowd.world().step();
        if (frame < 0) continue; // warm-up
        changes.push_back(changed), steps.push_back(milliseconds_since(begin) - changed);
    }
    return {median(changes), median(steps)};
}

/// Queries per second on this many threads, each with a part of the queries, one by one.
double time_queries(const World& world, std::span<const PlacedModel> queries, std::size_t threads)
{
    const auto begin = Clock::now();
    std::vector<std::thread> workers;
    for (std::size_t w = 0; w < threads; ++w)
        workers.emplace_back([&, w] {
            for (std::size_t i = w; i < queries.size(); i += threads) world.space().overlaps(queries[i]);
        });
    for (std::thread& worker : workers) worker.join();
    return double(queries.size()) / milliseconds_since(begin) * 1000;
}

/// Cost of a World's frames, by the number of changed bodies, and of its queries. Returns the exit code: 70 if a newly
/// made World finds other pairs.
int bench_world(const WorldOptions& options)
{
    check_range("--frames", options.frames, 1, 1'000'000);
    check_range("--bodies", options.bodies, 2, 1'000'000);
    check_range("--changes", options.changes, 1, options.bodies);
    check_files({{"--csv", options.csv}});
    CsvFile csv(options.csv, "bodies,pairs,refined_by,exact,skip,change,count,changes_ms,step_ms");

    const auto begin = Clock::now();
    Crowd crowd(options, std::uint32_t(options.bodies));
    const double made = milliseconds_since(begin);
    World& world = crowd.world();
    const std::size_t pairs = world.step().pairs.size();
    say("{}scene      many, {} bodies, {} pairs; made in {:.0f} ms, first frame after {:.0f} ms\n"
        "settings   {}\nframes     {}, medians\n\n",
        describe_program(world.inspect().backend), grouped(crowd.size()), grouped(pairs), made,
        milliseconds_since(begin), describe(world.settings()), options.frames);

    const auto changes = std::size_t(options.changes);
    say("{:<34}{:>14}{:>14}{:>14}\n", "ms per frame", "changes", "step", "together");
    const auto row = [&](const std::string& what, const char* kind, std::size_t count, auto change) {
        const auto [changed, step] = time_frames(crowd, options.frames, change);
        csv.row(crowd.size(), pairs, wants_obbs(world.settings()) ? "obb" : "sphere", name_of(world.settings().exact),
                fmt::format("{}", fmt::join(names_of(world.settings().skip), " ")), kind, count, Digits{changed, 4},
                Digits{step, 4});
        say("{:<34}{:>14.3f}{:>14.3f}{:>14.3f}\n", what, changed, step, changed + step);
        return changed + step;
    };
    row("nothing changes", "none", 0, [] {});
    const double moved = row(grouped(changes) + " move", "move", changes, [&] { crowd.move(changes); });
    const double exchanged = row(fmt::format("{0} removed, {0} added", grouped(changes)), "exchange", changes,
                                 [&] { crowd.exchange(changes); });
    row("all move", "move", crowd.size(), [&] { crowd.move(crowd.size()); });
    say("\nremoved and added / moved  {:.2f}\n", exchanged / moved);

    const std::vector<PlacedModel> queries = crowd.queries(10'000);
    world.space().overlaps(queries.front()); // applies the changes
    time_queries(world, queries, 1);         // warms up
    const double one = time_queries(world, queries, 1), two = time_queries(world, queries, 2);
    say("queries    {} per second from one thread, {} from two at the same time ({:.2f} times)\n",
        grouped(std::uint64_t(one)), grouped(std::uint64_t(two)), two / one);
    say("memory     World {} MB; process {} MB at its peak\n", world.inspect().bytes / 1'000'000,
        peak_memory() / 1'000'000);

    csv.commit();
    const bool same = crowd.is_as_made_anew();
    say("results    {} a newly made World\n", same ? "same as of" : "WRONG: not the same as of");
    return same ? 0 : int(ErrorKind::internal);
}

} // namespace

void add_world(Arguments bench)
{
    Arguments sub = bench.add_command("world", "Bodies that are added, removed and moved between frames, and queries");
    auto options = std::make_shared<WorldOptions>();
    auto settings = std::make_shared<SettingsOptions>();
    sub.add_option("--bodies N", options->bodies, "bodies (default 100000)");
    sub.add_option("--changes N", options->changes, "bodies moved, or removed and added, per frame (default 1000)");
    sub.add_option("--frames N", options->frames, "frames to time (default 20)");
    sub.add_option("--seed S", options->seed, "seed of the scene (default 12345)");
    sub.add_option("--csv FILE", options->csv, "write one row per kind of change");
    add_accuracy_options(sub, *settings);
    add_pipeline_options(sub, *settings);
    sub.footer("A newly made World must give the same results. Exit code 70: they differ.");
    sub.action([options, settings] {
        options->settings = settings_from(*settings);
        return bench_world(*options);
    });
}

} // namespace oncollide::tools
