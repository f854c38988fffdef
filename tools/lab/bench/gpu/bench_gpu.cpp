// oncollide-lab bench gpu: every measurement that needs a GPU, in one call, and each by itself: the paper's tables, the
// backends of sphere-trees, and comparators of the paper's related work.
#include "bench/common/benchmark.hpp"
#include "bench/gpu/exact_frames.hpp"
#include "bench/gpu/gpu_report.hpp"
#include "bench/gpu/gpu_sizes.hpp"
#include "bench/gpu/octant_candidate.hpp"
#include "bench/gpu/paper_methods.hpp"

#include <algorithm>
#include <bit>
#include <set>

#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/pipeline/world/world_access.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::tools {
namespace {

constexpr std::size_t timeline_windows = 12;

class GpuBench {
public:
    GpuBench(const GpuOptions& options, std::set<std::string> parts)
        : options_(options), parts_(std::move(parts)), gpu_(describe_gpu(options.gpu)),
          sizes_(sizes_of(options, gpu_.software)), data_(data_folder(options.data))
    {
        if (!options.scene.empty()) scene_of(sizes_.paper); // throws for an unknown scene before any output
    }

    /// Returns the number of faults.
    int run()
    {
        const auto limits = gpu_limits(options_.gpu);
        say("{}GPU        {}, {}, OpenGL {}; {}; context in {:.0f} ms\n", describe_program(make_cpu_backend()->name()),
            gpu_.renderer, gpu_.vendor, gpu_.version, gpu_.platform, gpu_.start_ms);
        for (const auto& [name, value] : limits) say("limit      {} {}\n", name, value);
        say("sizes      {}{}; no measurement begins after {} s\n", sizes_.name,
            sizes_.name == "small" ? ", for a software renderer or a test" : "", options_.limit_s);
        correctness(), exact(), octants(), trees(), misses(), levels(), many(), paper(), rivals();
        const double seconds = milliseconds_since(began_) / 1e3;
        say("\nfaults     {}; {:.0f} s in all\n", faults_, seconds);
        report_.commit();
        const bool after = options_.json.empty() && options_.csv.empty();
        if (after) say("\n"), flush_stdout();
        if (!after && options_.json.empty()) return faults_;
        OutputFile file(after ? "-" : options_.json);
        report_.write_json(file, gpu_, limits, sizes_.name, options_.limit_s, seconds);
        file.commit();
        return faults_;
    }

private:
    bool begin(const std::string& name, const std::string& title)
    {
        if (!parts_.contains(name)) return false;
        part_ = &report_.begin(name, title, options_.csv);
        return true;
    }
    template <class... NamesAndValues>
    void row(std::string_view what, std::string_view backend, const NamesAndValues&... more)
    {
        part_->table.row(figures("what", what, "backend", backend, more...));
    }
    Scene scene_of(const Cut& cut) const
    {
        return open_scene({.scene = cut.scene,
                           .bodies = cut.bodies,
                           .frames = cut.frames,
                           .seed = {},
                           .data = options_.data,
                           .cache = {}});
    }
    static std::string title(const Cut& cut)
    {
        std::string text = cut.scene;
        if (cut.bodies) text += ", " + grouped(std::size_t(*cut.bodies));
        if (cut.frames) text += fmt::format(", {} frames", grouped(std::size_t((*cut.frames - 1) / cut.every + 1)));
        return text;
    }
    /// False, and said so, if the time is up.
    bool time_for(const std::string& what)
    {
        if (milliseconds_since(began_) < options_.limit_s * 1e3) return true;
        part_->leave_out(fmt::format("{}: {} s are up", what, options_.limit_s));
        return false;
    }
    /// True if a measurement that began in time must stop.
    bool late() const { return milliseconds_since(began_) > (options_.limit_s + 45) * 1e3; }
    std::vector<Method> trees_on_backends() const { return tree_methods(options_.gpu, options_.viewport); }
    std::vector<Method> certified_trees() const
    {
        std::vector<Method> methods = trees_on_backends();
        std::erase_if(methods, [](const Method& method) { return !method.certified; });
        return methods;
    }

    /// gl-compute must find the cpu's results.
    void correctness()
    {
        if (!begin("correctness", "result hashes of gl-compute and cpu, spheres, an error of 1 % of the smaller body"))
            return;
        const Settings settings{.exact = ExactLevel::off, .bounding_volume = BoundingVolume::sphere};
        for (const Cut& cut : sizes_.equal) {
            if (!time_for(title(cut))) return;
            const Scene scene = scene_of(cut);
            std::vector<std::uint64_t> hashes;
            for (const Method& method : certified_trees())
                hashes.push_back(play(scene, settings, method, 1, cut.every).hash);
            const bool equal = hashes[0] == hashes[1];
            faults_ += !equal;
            row(title(cut), "gl-compute", "hash", Hex{hashes[1]}, "cpu_hash", Hex{hashes[0]}, "equal", equal);
        }
    }

    /// Exact results by the backend gl.
    void exact()
    {
        const ExactContest contest{options_.gpu, gpu_.renderer, hardware_threads()};
        if (begin("frames", "exact frames by gl and by the cpu; per frame after the first two"))
            for (const Cut& cut : sizes_.exact)
                if (time_for(title(cut)))
                    faults_ += exact_frames(contest, title(cut), scene_of(cut), cut.every, part_->table,
                                            [this] { return late(); });
        if (begin("batches", "one exact call for many poses of two meshes, the second time"))
            if (time_for("batches")) faults_ += exact_batches(contest, sizes_.poses, part_->table);
    }

    std::vector<OctantContender> contenders() const { return octant_contenders(options_.gpu, options_.all_backends); }
    NamedMesh mesh(std::size_t i) const { return mesh_or_knot(data_, sizes_.meshes[i].first, sizes_.meshes[i].second); }

    void octants()
    {
        if (!begin("octants", "batches of rows, one row for the octants of a cell (target: 24,000 rows in 0.2 ms)"))
            return;
        const std::vector<OctantContender> all = contenders();
        for (std::size_t i = 0; i < sizes_.meshes.size(); ++i) {
            const NamedMesh of = mesh(i);
            if (!time_for(of.name)) return;
            const OctantLevels levels(of.mesh, 8);
            for (const OctantContender& contender : all) {
                Candidate candidate(contender, levels);
                double row_ms = 0;
                for (const std::size_t rows : sizes_.rows) {
                    if (row_ms * double(rows) > sizes_.batch_s * 1e3) continue; // predicted from the batch before
                    const OctantTime time = candidate.measure(rows, sizes_.repeats);
                    row_ms = time.ms / double(rows);
                    row(of.name, contender.name, "triangles", of.mesh.triangles.size(), "rows", rows, "ms", time.ms,
                        "gpu_ms", time.gpu_ms, "octants_per_s", 8e3 * double(rows) / time.ms);
                }
            }
        }
    }

    void trees()
    {
        if (!begin("trees", "a whole tree, one batch per level (target: bunny_69k to depth 7 in 0.5 ms of GPU time)"))
            return;
        for (std::size_t i = sizes_.meshes.size() - sizes_.tree_meshes; i < sizes_.meshes.size(); ++i) {
            const NamedMesh of = mesh(i);
            if (!time_for(of.name)) return;
            const OctantLevels levels(of.mesh, sizes_.depths.back());
            for (const OctantContender& contender : contenders()) {
                if (contender.name.starts_with("gl-query")) continue; // would take minutes
                Candidate candidate(contender, levels);
                for (const int depth : sizes_.depths) {
                    const OctantTime time = candidate.measure_tree(depth, sizes_.repeats);
                    row(fmt::format("{}, depth {}", of.name, depth), contender.name, "triangles",
                        of.mesh.triangles.size(), "ms", time.ms, "gpu_ms", time.gpu_ms);
                }
            }
        }
    }

    /// Missed and extra octants, over all true cells above a depth.
    void misses()
    {
        const int depth = sizes_.missed_depth;
        if (!begin("misses", fmt::format("octants to depth {} that the surface enters by an exact test: missed, and "
                                         "reported although it does not enter them",
                                         depth)))
            return;
        std::vector<NamedMesh> meshes;
        for (std::size_t i = 0; i < sizes_.missed_meshes; ++i) meshes.push_back(mesh(i));
        meshes.push_back({"needles", make_needles_mesh(300, 1, 1e4, 3, 7)});
        meshes.push_back({"tiny triangles", make_soup_mesh(400, 1e-4, 3, 9)});
        for (const NamedMesh& of : meshes) {
            if (!time_for(of.name)) return;
            const OctantLevels levels(of.mesh, depth);
            for (const OctantContender& contender : contenders()) {
                if (contender.threads > 1) continue;
                Candidate candidate(contender, levels);
                std::uint64_t octants = 0, missed = 0, extra = 0, queries = 0;
                const auto see = [&](unsigned truth, unsigned found) {
                    octants += std::uint64_t(std::popcount(truth));
                    missed += std::uint64_t(std::popcount(truth & ~found));
                    extra += std::uint64_t(std::popcount(found & ~truth));
                };
                for (int level = 0; level < depth; ++level) queries += candidate.grow_level(see).queries;
                row(of.name, contender.name, "triangles", of.mesh.triangles.size(), "octants", octants, "missed",
                    missed, "extra", extra, "queries", queries);
            }
        }
    }

    /// The paper's Table 1.
    void levels()
    {
        if (!begin("levels", "one level of a tree, the paper's Table 1 (the paper: 9 to 13 queries)")) return;
        for (const auto& [file, triangles] : level_models()) {
            const NamedMesh of = mesh_or_knot(data_, file, triangles);
            if (!time_for(of.name)) return;
            const OctantLevels one(of.mesh, 1);
            for (const Method& method : trees_on_backends()) {
                const auto [ms, work] = one_level(one, method);
                row(of.name, method.name, "triangles", of.mesh.triangles.size(), "ms", ms, "gpu_ms", work.gpu_ms,
                    "queries", work.queries);
            }
        }
    }

    /// Adds a row for each method on a scene, with the collisions that it misses. The first method must be the cpu.
    /// Returns the methods' results by name.
    std::vector<std::pair<std::string, Played>> compare(const Cut& cut, const std::vector<Method>& methods)
    {
        std::vector<std::pair<std::string, Played>> all;
        if (!time_for(title(cut))) return all;
        const Scene scene = scene_of(cut);
        const PairsByFrame truth = true_pairs(scene, cut.every);
        const Settings settings{.depth = options_.depth, .age_limit = options_.age};
        for (const Method& method : methods) {
            const std::string what = fmt::format("{}, {}", title(cut), method.name);
            if (!time_for(what)) continue;
            const std::size_t windows = std::min(timeline_windows, std::size_t(scene.frames));
            Played played = play(scene, settings, method, int(windows), cut.every, [this] { return late(); });
            if (played.stopped) {
                part_->leave_out(fmt::format("{}: stopped, {} s are up", what, options_.limit_s));
                continue;
            }
            const Window sum = played.total();
            const auto [slowest, fastest] = played.least_and_most_per_s();
            const std::uint64_t lost = missed(truth, played.left);
            faults_ += lost && method.certified;
            if (part_->name != "timeline")
                row(title(cut), method.name, "frames", sum.frames, "seconds", sum.ms / 1e3, "frames_per_s",
                    1e3 * double(sum.frames) / sum.ms, "slowest_per_s", slowest, "fastest_per_s", fastest, "queries",
                    sum.queries, "cells", sum.cells, "candidates", played.candidates, "left_over", played.left_over(),
                    "lost", missed(all.empty() ? played.left : all.front().second.left, played.left), "collisions",
                    count_pairs(truth), "missed", lost, "hash", Hex{played.hash});
            all.emplace_back(method.name, std::move(played));
        }
        return all;
    }

    /// The paper's Tables 2 and 3.
    void paper()
    {
        std::vector<Method> methods = trees_on_backends();
        const bool totals =
            begin("paper", fmt::format("the paper's animation, depth {}, CULLIDE at {} pixels (the paper, 2004: 8.58 s "
                                       "with soup, 7.36 s with strips, 178 to 349 frames per second)",
                                       options_.depth, sizes_.cullide_pixels));
        if (totals) {
            const std::vector<Method> more = comparators(options_.gpu, sizes_.cullide_pixels);
            methods.insert(methods.end(), more.begin(), more.end());
        }
        std::vector<std::pair<std::string, Played>> played;
        if (totals) played = compare(sizes_.paper, methods);
        if (!begin("timeline", "the same, by parts of the animation")) return;
        if (!totals || played.empty()) played = compare(sizes_.paper, methods);
        for (const auto& [name, of] : played) {
            std::uint64_t to_frame = 0;
            for (const Window& w : of.windows)
                row(title(sizes_.paper), name, "to_frame", to_frame += w.frames, "frames", w.frames, "ms", w.ms,
                    "frames_per_s", w.frames ? 1e3 * double(w.frames) / w.ms : 0, "queries", w.queries, "cells",
                    w.cells);
        }
    }

    void rivals()
    {
        if (!begin("comparators", fmt::format("left over; lost: pairs that the cpu leaves over and a method does not; "
                                              "missed against exact truth; spheres of depth {}, CULLIDE at {} pixels",
                                              options_.depth, sizes_.cullide_pixels)))
            return;
        std::vector<Method> methods = trees_on_backends();
        std::erase_if(methods, [](const Method& m) { return m.name.ends_with("soup") || m.name.ends_with("strips"); });
        for (const Method& method : comparators(options_.gpu, sizes_.cullide_pixels)) methods.push_back(method);
        for (const Cut& cut : sizes_.comparators) compare(cut, methods);
    }

    /// The first frame, in which trees grow, and the others; trees that grow on demand, and ahead of the traversals.
    void many()
    {
        if (!begin("many", "cold and warm frames, spheres, an error of 1 % of the smaller body; 'ahead': cells grow "
                           "ahead of the traversals"))
            return;
        for (const Cut& cut : sizes_.many)
            for (const Method& method : certified_trees())
                for (const bool ahead : {false, true})
                    if (const std::string name = method.name + (ahead ? ", ahead" : "");
                        time_for(fmt::format("{}, {}", title(cut), name)))
                        play_many(cut, method, ahead, name);
    }

    void play_many(const Cut& cut, const Method& method, bool ahead, const std::string& name)
    {
        Scene scene = scene_of(cut);
        const Settings settings{.exact = ExactLevel::off, .bounding_volume = BoundingVolume::sphere};
        Pipeline pipeline(scene, method.make(settings));
        WorldAccess::grow_ahead(pipeline.world(), ahead);
        Mover mover;
        struct Sum {
            double ms = 0, gpu_ms = 0, wait_ms = 0;
            std::uint64_t rounds = 0;
        } sums[2]; // the first frame, the others
        for (int frame = 0; frame < scene.frames; ++frame) {
            mover.move(scene, frame);
            const FrameView view = pipeline.step(scene);
            Sum& sum = sums[frame > 0];
            sum.ms += view.ms, sum.rounds += view.rounds.size();
            for (const Round& round : view.rounds) sum.gpu_ms += round.gpu_ms, sum.wait_ms += round.wait_ms;
        }
        const double warm = scene.frames - 1;
        row(title(cut), name, "first_ms", sums[0].ms, "first_gpu_ms", sums[0].gpu_ms, "first_wait_ms", sums[0].wait_ms,
            "first_rounds", sums[0].rounds, "warm_ms", sums[1].ms / warm, "warm_gpu_ms", sums[1].gpu_ms / warm,
            "warm_rounds", double(sums[1].rounds) / warm, "hash", Hex{pipeline.hash()});
    }

    const GpuOptions& options_;
    std::set<std::string> parts_;
    GpuInfo gpu_;
    Sizes sizes_;
    std::filesystem::path data_;
    GpuReport report_;
    GpuPart* part_ = nullptr;
    Clock::time_point began_ = Clock::now();
    int faults_ = 0;
};

/// Returns the exit code: 70 if a result differs from the cpu's or a certified method missed a collision.
int bench_gpu(const GpuOptions& options)
{
    if (!(options.limit_s > 0)) usage(fmt::format("--limit {}: must be above 0 seconds", options.limit_s));
    if (!(options.batch_s.value_or(1) > 0)) usage("--batch-limit: must be above 0 seconds");
    check(Settings{.depth = options.depth, .viewport = options.viewport, .age_limit = options.age});
    sizes_of(options, true);
    std::set<std::string> parts(gpu_parts.begin(), gpu_parts.end());
    if (!options.parts.empty()) {
        const std::vector<std::string> named = split(options.parts);
        for (const std::string& part : named)
            if (!parts.contains(part))
                usage(fmt::format("--part {}: unknown{}", part,
                                  valid_names(part, {gpu_parts.begin(), gpu_parts.end()}, "valid")));
        parts = {named.begin(), named.end()};
    }
    if (!options.csv.empty() && parts.size() != 1) usage("--csv: needs a single --part, whose table it writes");
    return code_of(GpuBench(options, std::move(parts)).run() > 0);
}

} // namespace

void add_gpu(Arguments bench)
{
    Benchmark<GpuOptions> b(
        bench, "gpu",
        "Everything that needs a GPU, in at most 8 minutes: results against the cpu's, speed of each "
        "backend, the paper's tables, comparators (CULLIDE, viewing volumes)",
        bench_gpu);
    b.option("--part LIST", b->parts,
             "only these parts: correctness, frames, batches, octants, trees, misses, levels, many, paper, timeline, "
             "comparators");
    b.option("--sizes SIZES", b->sizes, "full, small, or auto: small on a software renderer, else full (default auto)");
    b.option("--limit S", b->limit_s, "seconds after which no further measurement begins (default 420)");
    b.option("--batch-limit S", b->batch_s,
             "skip batches of octants that would take longer (seconds, default 2; small sizes: 0.2)");
    b.flag("--all-backends", b->all_backends,
           "octants, trees and misses: also several threads, and all viewports and primitives of gl-query");
    b.whole("--repeats N", b->runs, "number of runs of octants and trees; the least time counts (default 5; small: 2)",
            {1, 1000});
    b.option("--scene SCENE", b->scene,
             "scene of frames, paper, timeline and comparators: a file, or a name from 'oncollide scene --list'");
    b.whole("--bodies N", b->bodies, "bodies of these scenes");
    b.whole("--frames N", b->frames, "frames of these scenes");
    b.whole("--every N", b->every, "play every N-th frame of them");
    b.whole("--poses N", b->poses, "poses of batches (default 1,000,000; small sizes: 1,000)", {1, 100'000'000});
    b.option("--depth D", b->depth, "depth of their sphere-trees (default 5, as in the paper)");
    b.option("--age N", b->age, "frames after which unused cells are dropped (default 60)");
    b.option("--viewport PX", b->viewport, "gl-query: pixels per side of a cell (default 16)");
    b.gpu(), b.data(), b.csv("measurement of the one part");
    b.output("--json", "FILE", b->json, "write the JSON to a file, instead of standard output after the table");
    b.footer("Exit code 70: a result differs from the cpu's, or a certified method missed a collision; 71: no GPU.\n"
             "Example:\n"
             "  oncollide-lab bench gpu --part comparators --scene many --bodies 40 --frames 2 --csv many.csv");
}

} // namespace oncollide::tools
