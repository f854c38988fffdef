// oncollide-lab bench world: cost of a frame by the number of bodies added, removed or moved, and cost of queries.
#include "bench/common/benchmark.hpp"
#include "cli/system.hpp"

#include <algorithm>
#include <numeric>
#include <set>
#include <thread>
#include <tuple>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/catalogue.hpp>

namespace oncollide::tools {
namespace {

struct WorldOptions : SharedOptions {
    int bodies = 100'000;
    int changes = 1000; ///< bodies that move, or are removed and added, per frame
    int frames = 20;
    SettingsOptions given;
    Settings settings;
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
    check_range("--changes", options.changes, 1, options.bodies);
    const auto begin = Clock::now();
    Crowd crowd(options, std::uint32_t(options.bodies));
    const double made = milliseconds_since(begin);
    World& world = crowd.world();
    const std::size_t pairs = world.step().pairs.size();
    say("{}scene      many, {} bodies, {} pairs; made in {:.0f} ms, first frame after {:.0f} ms\n"
        "settings   {}\nframes     {}; medians, ms per frame\n\n",
        describe_program(world.inspect().backend), grouped(crowd.size()), grouped(pairs), made,
        milliseconds_since(begin), describe(world.settings()), options.frames);

    ResultTable table(options.csv);
    table.about(figures("bodies", crowd.size(), "pairs", pairs, "refined_by",
                        wants_obbs(world.settings()) ? "obb" : "sphere", "exact", name_of(world.settings().exact),
                        "skip", fmt::format("{}", fmt::join(names_of(world.settings().skip), " "))));
    const auto row = [&](const char* change, std::size_t count, auto work) {
        const auto [changed, step] = time_frames(crowd, options.frames, work);
        table.row(figures("change", change, "count", count, "changes_ms", changed, "step_ms", step, "together_ms",
                          changed + step));
        return changed + step;
    };
    const auto changes = std::size_t(options.changes);
    row("none", 0, [] {});
    const double moved = row("move", changes, [&] { crowd.move(changes); });
    const double exchanged = row("exchange", changes, [&] { crowd.exchange(changes); });
    row("move", crowd.size(), [&] { crowd.move(crowd.size()); });
    say("\nremoved and added / moved  {:.2f}\n", exchanged / moved);

    const std::vector<PlacedModel> queries = crowd.queries(10'000);
    world.space().overlaps(queries.front()); // applies the changes
    time_queries(world, queries, 1);         // warms up
    const double one = time_queries(world, queries, 1), two = time_queries(world, queries, 2);
    say("queries    {} per second from one thread, {} from two at the same time ({:.2f} times)\n",
        grouped(std::uint64_t(one)), grouped(std::uint64_t(two)), two / one);
    say("memory     World {} MB; process {} MB at its peak\n", world.inspect().bytes / 1'000'000,
        peak_memory() / 1'000'000);
    table.commit();
    const bool same = crowd.is_as_made_anew();
    say("results    {} a newly made World\n", same ? "same as of" : "WRONG: not the same as of");
    return code_of(!same);
}

} // namespace

void add_world(Arguments bench)
{
    Benchmark<WorldOptions> b(bench, "world", "Bodies that are added, removed and moved between frames, and queries",
                              bench_world);
    b.whole("--bodies N", b->bodies, "bodies", {2, 1'000'000});
    b.whole("--changes N", b->changes, "bodies moved, or removed and added (exchange), per frame");
    b.whole("--frames N", b->frames, "frames to time", {1, 1'000'000});
    b.seed("the scene"), b.csv("kind of change");
    add_accuracy_options(b.arguments(), b->given);
    add_pipeline_options(b.arguments(), b->given);
    b.prepare([](WorldOptions& o) { o.settings = settings_from(o.given); });
    b.footer("A newly made World must give the same results. Exit code 70: they differ.");
}

} // namespace oncollide::tools
