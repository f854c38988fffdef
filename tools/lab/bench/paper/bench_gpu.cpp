// oncollide-lab bench gpu: every measurement that needs a GPU, in one call.
#include "bench/bench.hpp"
#include "bench/paper/gpu_report.hpp"
#include "bench/paper/octant_candidate.hpp"
#include "bench/paper/paper_methods.hpp"
#include "cli/options.hpp"
#include "cli/standard_output.hpp"
#include "common/text.hpp"

#include <memory>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide::tools {
namespace {

struct GpuOptions {
    std::string data, json, sizes = "auto";
    int gpu = -1;
    double limit_s = 420; ///< no measurement begins later
};

/// A scene of the catalogue, cut to a size.
struct Cut {
    const char* scene;
    std::optional<int> bodies;
    int frames;
    int every = 1; ///< frames are played
};

struct Sizes {
    std::string name;
    std::vector<Cut> equal;                          ///< scenes whose hashes are compared
    std::vector<std::pair<const char*, int>> meshes; ///< of octants; the last one also of whole trees
    std::vector<std::size_t> rows;
    std::vector<int> depths; ///< of whole trees
    Cut paper;
    std::vector<Cut> many, comparators;
    int cullide_pixels; ///< per side
    int repeats;
    double batch_s; ///< batches predicted to take longer are left out
};

Sizes full_sizes()
{
    return {.name = "full",
            .equal = {{"many", 1000, 10}, {"paper", {}, 2400, 4}, {"hard", {}, 3}},
            .meshes = {{"paper/lamp.obj", 600},
                       {"paper/bunny.obj", 1500},
                       {"paper/cow_5144.obj", 5144},
                       {"bunny_69k.obj", 69451}},
            .rows = {24, 240, 2400, 24000},
            .depths = {5, 6, 7},
            .paper = {"paper", {}, 2400},
            .many = {{"many", 1000, 30}, {"many", 10000, 8}},
            .comparators = {{"many", 100, 6}, {"hard", {}, 3}},
            .cullide_pixels = 512,
            .repeats = 5,
            .batch_s = 2};
}

Sizes small_sizes()
{
    return {.name = "small",
            .equal = {{"many", 100, 3}, {"paper", {}, 2400, 24}, {"hard", {}, 1}},
            .meshes = {{"paper/lamp.obj", 600}, {"paper/cow_5144.obj", 5144}},
            .rows = {24, 240, 2400},
            .depths = {4, 5},
            .paper = {"paper", {}, 2400, 150},
            .many = {{"many", 100, 4}},
            .comparators = {{"many", 12, 1}, {"hard", {}, 1}},
            .cullide_pixels = 128,
            .repeats = 2,
            .batch_s = 0.2};
}

Sizes sizes_of(const std::string& name, bool software)
{
    if (name == "full" || (name == "auto" && !software)) return full_sizes();
    if (name == "small" || name == "auto") return small_sizes();
    usage(fmt::format("--sizes {}: valid are auto, full, small", name));
}

class GpuBench {
public:
    GpuBench(const GpuOptions& options, const GpuInfo& gpu)
        : options_(options), gpu_(gpu), sizes_(sizes_of(options.sizes, gpu.software)), data_(data_folder(options.data))
    {
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
        correctness(), octants(), trees(), levels(), many(), paper(), rivals();
        const double seconds = milliseconds_since(began_) / 1e3;
        say("\nfaults     {}; {:.0f} s in all\n", faults_, seconds);
        const bool after = options_.json.empty();
        if (after) say("\n"), flush_stdout();
        OutputFile file(after ? "-" : options_.json);
        report_.write_json(file, gpu_, limits, sizes_.name, options_.limit_s, seconds);
        file.commit();
        return faults_;
    }

private:
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
        return fmt::format("{}{}, {} frames", cut.scene,
                           cut.bodies ? ", " + grouped(std::size_t(*cut.bodies)) : std::string(),
                           grouped(std::size_t(cut.frames / cut.every)));
    }
    /// False, and said so, if the time is up.
    bool time_for(const std::string& what)
    {
        if (milliseconds_since(began_) < options_.limit_s * 1e3) return true;
        report_.leave_out(fmt::format("{}: {} s are up", what, options_.limit_s));
        return false;
    }
    /// True if a measurement that began in time must stop.
    bool late() const { return milliseconds_since(began_) > (options_.limit_s + 45) * 1e3; }
    std::vector<Method> certified_trees() const
    {
        std::vector<Method> methods = tree_methods(options_.gpu, 16);
        std::erase_if(methods, [](const Method& method) { return !method.certified; });
        return methods;
    }

    /// gl-compute must find the cpu's results.
    void correctness()
    {
        report_.begin("correctness",
                      "result hashes of gl-compute and cpu, spheres, an error of 1 % of the smaller body");
        const Settings settings{.exact = ExactLevel::off, .bounding_volume = BoundingVolume::sphere};
        for (const Cut& cut : sizes_.equal) {
            if (!time_for(title(cut))) return;
            const Scene scene = scene_of(cut);
            std::vector<std::uint64_t> hashes;
            for (const Method& method : certified_trees())
                hashes.push_back(play(scene, settings, method, 1, cut.every).hash);
            const bool equal = hashes[0] == hashes[1];
            faults_ += !equal;
            report_.row(title(cut), "gl-compute",
                        {{"hash", fmt::format("{:016x}", hashes[0])},
                         {"cpu_hash", fmt::format("{:016x}", hashes[1])},
                         {"equal", equal}});
        }
    }

    std::vector<OctantContender> contenders() const
    {
        std::vector<OctantContender> some = octant_contenders(options_.gpu);
        std::erase_if(some, [](const OctantContender& c) {
            return c.threads > 1 || (c.name.starts_with("gl-query") && c.name != "gl-query 16 px, soup" &&
                                     c.name != "gl-query 16 px, inherited");
        });
        return some;
    }

    void octants()
    {
        report_.begin("octants", "batches of rows, one row for the octants of a cell (target: 24,000 rows in 0.2 ms)");
        const std::vector<OctantContender> all = contenders();
        for (const auto& [file, triangles] : sizes_.meshes) {
            const NamedMesh mesh = mesh_or_knot(data_, file, triangles);
            if (!time_for(mesh.name)) return;
            const OctantLevels levels(mesh.mesh, 8);
            for (const OctantContender& contender : all) {
                Candidate candidate(contender, levels);
                double row_ms = 0;
                for (const std::size_t rows : sizes_.rows) {
                    if (row_ms * double(rows) > sizes_.batch_s * 1e3) continue;
                    const OctantTime time = candidate.measure(rows, sizes_.repeats);
                    row_ms = time.ms / double(rows);
                    report_.row(mesh.name, contender.name,
                                {{"rows", rows},
                                 {"ms", time.ms},
                                 {"gpu_ms", time.gpu_ms},
                                 {"octants_per_s", 8e3 * double(rows) / time.ms}});
                }
            }
        }
    }

    void trees()
    {
        report_.begin("trees",
                      "a whole tree, one batch per level (target: bunny_69k to depth 7 in 0.5 ms of GPU time)");
        const auto& [file, triangles] = sizes_.meshes.back();
        const NamedMesh mesh = mesh_or_knot(data_, file, triangles);
        if (!time_for(mesh.name)) return;
        const OctantLevels levels(mesh.mesh, sizes_.depths.back());
        for (const OctantContender& contender : contenders()) {
            if (contender.name.starts_with("gl-query")) continue;
            Candidate candidate(contender, levels);
            for (const int depth : sizes_.depths) {
                const OctantTime time = candidate.measure_tree(depth, sizes_.repeats);
                report_.row(fmt::format("{}, depth {}", mesh.name, depth), contender.name,
                            {{"ms", time.ms}, {"gpu_ms", time.gpu_ms}});
            }
        }
    }

    /// The paper's Table 1.
    void levels()
    {
        report_.begin("levels", "one level of a tree, the paper's Table 1 (the paper: 9 to 13 queries)");
        for (const auto& [file, triangles] : level_models()) {
            const NamedMesh mesh = mesh_or_knot(data_, file, triangles);
            if (!time_for(mesh.name)) return;
            const OctantLevels one(mesh.mesh, 1);
            for (const Method& method : tree_methods(options_.gpu, 16)) {
                const auto [ms, work] = one_level(one, method);
                report_.row(mesh.name, method.name, {{"ms", ms}, {"gpu_ms", work.gpu_ms}, {"queries", work.queries}});
            }
        }
    }

    /// The methods on a scene, and the collisions that each misses.
    void compare(const Cut& cut, const std::vector<Method>& methods)
    {
        if (!time_for(title(cut))) return;
        const Scene scene = scene_of(cut);
        const PairsByFrame truth = true_pairs(scene, cut.every);
        for (const Method& method : methods) {
            if (!time_for(fmt::format("{}, {}", title(cut), method.name))) continue;
            const Played played = play(scene, {.depth = 5}, method, 1, cut.every, [this] { return late(); });
            if (played.stopped) {
                report_.leave_out(
                    fmt::format("{}, {}: stopped, {} s are up", title(cut), method.name, options_.limit_s));
                continue;
            }
            const Window all = played.total();
            const std::uint64_t lost = missed(truth, played.left);
            faults_ += lost && method.certified;
            report_.row(title(cut), method.name,
                        {{"seconds", all.ms / 1e3},
                         {"frames_per_s", 1e3 * double(all.frames) / all.ms},
                         {"queries", all.queries},
                         {"candidates", played.candidates},
                         {"left_over", played.left_over()},
                         {"collisions", count_pairs(truth)},
                         {"missed", lost}});
        }
    }

    void paper()
    {
        report_.begin("paper",
                      fmt::format("the paper's animation, depth 5, CULLIDE at {} pixels (the paper, 2004: 8.58 s with "
                                  "soup, 7.36 s with strips)",
                                  sizes_.cullide_pixels));
        std::vector<Method> methods = tree_methods(options_.gpu, 16);
        for (const Method& method : comparators(options_.gpu, sizes_.cullide_pixels)) methods.push_back(method);
        compare(sizes_.paper, methods);
    }

    void rivals()
    {
        report_.begin("comparators",
                      fmt::format("left over, and missed against exact truth; spheres of depth 5, CULLIDE at "
                                  "{} pixels",
                                  sizes_.cullide_pixels));
        std::vector<Method> methods = comparators(options_.gpu, sizes_.cullide_pixels);
        for (const Method& method : tree_methods(options_.gpu, 16))
            if (method.name != "gl-query, soup" && method.name != "gl-query, strips") methods.push_back(method);
        for (const Cut& cut : sizes_.comparators) compare(cut, methods);
    }

    /// The first frame, in which trees grow, and the others; trees that grow on demand, and ahead of the traversals.
    void many()
    {
        report_.begin("many", "cold and warm frames, spheres, an error of 1 % of the smaller body; 'ahead': cells grow "
                              "ahead of the traversals");
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
        for (int frame = 0; frame < cut.frames; ++frame) {
            mover.move(scene, frame);
            const FrameView view = pipeline.step(scene);
            Sum& sum = sums[frame > 0];
            sum.ms += view.ms, sum.rounds += view.rounds.size();
            for (const Round& round : view.rounds) sum.gpu_ms += round.gpu_ms, sum.wait_ms += round.wait_ms;
        }
        const double warm = cut.frames - 1;
        report_.row(title(cut), name,
                    {{"first_ms", sums[0].ms},
                     {"first_gpu_ms", sums[0].gpu_ms},
                     {"first_wait_ms", sums[0].wait_ms},
                     {"first_rounds", sums[0].rounds},
                     {"warm_ms", sums[1].ms / warm},
                     {"warm_gpu_ms", sums[1].gpu_ms / warm},
                     {"warm_rounds", double(sums[1].rounds) / warm},
                     {"hash", fmt::format("{:016x}", pipeline.hash())}});
    }

    GpuOptions options_;
    GpuInfo gpu_;
    Sizes sizes_;
    std::filesystem::path data_;
    GpuReport report_;
    Clock::time_point began_ = Clock::now();
    int faults_ = 0;
};

/// Returns the exit code: 70 if a result differs from the cpu's or a certified method missed a collision.
int bench_gpu(const GpuOptions& options)
{
    if (!(options.limit_s > 0)) usage(fmt::format("--limit {}: must be above 0 seconds", options.limit_s));
    sizes_of(options.sizes, true);
    check_files({{"--json", options.json}});
    const int faults = GpuBench(options, describe_gpu(options.gpu)).run();
    return faults ? int(ErrorKind::internal) : 0;
}

} // namespace

void add_gpu(Arguments bench)
{
    Arguments sub =
        bench.add_command("gpu", "Everything that needs a GPU, in at most 8 minutes: results against the cpu's, "
                                 "speed of each backend, comparators");
    auto options = std::make_shared<GpuOptions>();
    sub.add_option("--sizes SIZES", options->sizes,
                   "full, small, or auto: small on a software renderer, else full (default auto)");
    sub.add_option("--limit S", options->limit_s, "seconds after which no further measurement begins (default 420)");
    sub.add_option("--gpu N", options->gpu, "number of the GPU ('oncollide doctor' lists them)");
    sub.add_option("--data DIR", options->data, "folder with meshes/ (default: $ONCOLLIDE_DATA, else ../shared/data)");
    sub.add_option("--json FILE", options->json,
                   "write the JSON to a file, instead of standard output after the table");
    sub.footer("Exit code 70: a result differs from the cpu's, or a certified method missed a collision; 71: no GPU.");
    sub.action([options] { return bench_gpu(*options); });
}

} // namespace oncollide::tools
