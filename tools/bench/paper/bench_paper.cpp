// oncollide bench paper: the paper's tables, with its method and with oncollide's other backends.
#include "bench/bench.hpp"
#include "bench/paper/octant_levels.hpp"
#include "cli/options.hpp"
#include "common/text.hpp"

#include <algorithm>
#include <functional>
#include <memory>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/narrowphase/gl/gpu.hpp>
#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide::tools {
namespace {

struct PaperOptions {
    std::string data, csv;
    std::optional<int> frames;
    int gpu = -1, viewport = 16, depth = 5, age = Settings{}.age_limit;
    bool large = false;
};

using Query = GlQueryOptions;

struct Method {
    std::string name;
    std::function<std::unique_ptr<OcclusionBackend>()> make;
};

std::vector<Method> methods(const PaperOptions& options)
{
    const auto query = [&](Query::Primitives primitives, Query::Draw draw) {
        return [=, gpu = options.gpu, viewport = options.viewport] {
            return make_gl_query_backend({.gpu = gpu,
                                          .viewport = viewport,
                                          .primitives = primitives,
                                          .samples = Query::Samples::passed,
                                          .draw = draw});
        };
    };
    return {{"gl-query, soup", query(Query::Primitives::soup, Query::Draw::mesh)},
            {"gl-query, strips", query(Query::Primitives::strips, Query::Draw::mesh)},
            {"gl-query, inherited", query(Query::Primitives::indexed, Query::Draw::inherited)},
            {"gl-compute", [gpu = options.gpu] { return make_gl_compute_backend({.gpu = gpu}); }},
            {"cpu", make_cpu_backend}};
}

/// A part of the animation.
struct Window {
    double ms = 0;
    std::uint64_t frames = 0, queries = 0, cells = 0;
};

struct Played {
    std::vector<Window> windows;
    std::vector<std::vector<BodyPair>> within; ///< by frame
    double first_ms = 0;
    std::uint64_t hash = 0;

    Window total() const
    {
        Window sum;
        for (const Window& w : windows)
            sum.ms += w.ms, sum.frames += w.frames, sum.queries += w.queries, sum.cells += w.cells;
        return sum;
    }
};

Played play(Scene scene, const PaperOptions& options, std::unique_ptr<OcclusionBackend> backend)
{
    constexpr int windows = 12;
    Played played;
    played.windows.resize(windows);
    Settings settings{.depth = options.depth, .age_limit = options.age};
    Pipeline pipeline(scene, WorldAccess::make(settings, std::move(backend)));
    Mover mover;
    for (int frame = 0; frame < scene.frames; ++frame) {
        mover.move(scene, frame);
        const FrameView view = pipeline.step(scene);
        if (frame == 0) played.first_ms = view.ms;
        Window& window = played.windows[static_cast<std::size_t>(frame * windows / scene.frames)];
        window.ms += view.ms, window.frames += 1, window.queries += view.trees.queries, window.cells += view.trees.rows;
        std::vector<BodyPair>& within = played.within.emplace_back();
        for (const PairResult& pair : view.pairs)
            if (pair.verdict != Verdict::separate) within.push_back({index(pair.a), index(pair.b)});
    }
    played.hash = pipeline.hash();
    return played;
}

/// Number of pairs of `truth`, over all frames, that `other` missed.
std::uint64_t lost(const Played& truth, const Played& other)
{
    std::uint64_t count = 0;
    for (std::size_t frame = 0; frame < truth.within.size(); ++frame)
        for (BodyPair pair : truth.within[frame])
            count += !std::binary_search(other.within[frame].begin(), other.within[frame].end(), pair);
    return count;
}

class PaperBench {
public:
    explicit PaperBench(const PaperOptions& options) : options_(options), methods_(methods(options))
    {
        if (!options.csv.empty()) csv_.emplace(options.csv, "table,what,backend,frames,ms,queries,cells");
    }

    void run()
    {
        const GpuInfo gpu = describe_gpu(options_.gpu);
        say("{}GPU        {}, OpenGL {}; {} pixels per side, samples passed\n\n",
            describe_program(make_cpu_backend()->name()), gpu.renderer, gpu.version, options_.viewport);
        table_1();
        tables_2_and_3();
        if (csv_) csv_->commit();
    }

private:
    /// A level of the tree: the root's eight octants.
    void table_1()
    {
        say("Table 1: one level of the tree (the paper: 9 to 13 queries)\n{:<16}{:>10}{:>9}", "model", "triangles",
            "queries");
        for (const Method& method : methods_) say("{:>21}", method.name);
        say("   ms\n");
        const std::filesystem::path data = data_folder(options_.data);
        for (const auto& [file, triangles] :
             std::initializer_list<std::pair<const char*, int>>{{"paper/lamp.obj", 600},
                                                                {"woody.obj", 1267},
                                                                {"paper/dragon.obj", 1496},
                                                                {"paper/bunny.obj", 1500},
                                                                {"paper/cow.obj", 1500},
                                                                {"beetle.obj", 2053},
                                                                {"spot.obj", 5856}}) {
            const NamedMesh mesh = mesh_or_knot(data, file, triangles);
            const OctantLevels levels(mesh.mesh, 1);
            std::string times;
            std::uint64_t queries = 0;
            for (const Method& method : methods_) {
                const auto [ms, work] = one_level(levels, *method.make());
                queries = std::max(queries, work.queries);
                times += fmt::format("{:>21.4f}", ms);
                if (csv_) csv_->row(1, mesh.name, Quoted{method.name}, std::nullopt, ms, work.queries, 1);
            }
            say("{:<16}{:>10}{:>9}{}\n", mesh.name, grouped(mesh.mesh.triangles.size()), queries, times);
        }
        say("\n");
    }

    static std::pair<double, BatchWork> one_level(const OctantLevels& levels, OcclusionBackend& backend)
    {
        backend.attach(0, levels.surface());
        const std::vector<OctantRow> rows{{0, root_cell, all_triangles, false}};
        std::vector<OctantResult> results(1);
        std::pair<double, BatchWork> best{1e300, {}};
        for (int repeat = 0; repeat < 10; ++repeat) {
            const Clock::time_point from = Clock::now();
            const BatchWork work = backend.run(rows, 1, results);
            const double ms = milliseconds_since(from);
            if (ms < best.first) best = {ms, work};
        }
        return best;
    }

    void tables_2_and_3()
    {
        const Scene scene = open_scene({.scene = options_.large ? "paper-5k" : "paper",
                                        .bodies = {},
                                        .frames = options_.frames,
                                        .seed = {},
                                        .data = options_.data,
                                        .cache = {}});
        say("Tables 2 and 3: the animation, {} frames, depth {}, cells dropped after {} frames\n"
            "(the paper: 1,500 triangles per model, on a notebook of 2004: 8.58 s with soup, 7.36 s with strips, 178 "
            "to 349 frames per second)\n",
            scene.frames, options_.depth, options_.age);
        std::vector<Played> played;
        for (const Method& method : methods_) played.push_back(play(scene, options_, method.make()));
        print_totals(played);
        print_timeline(played);
    }

    void print_totals(const std::vector<Played>& played) const
    {
        say("{:<22}{:>10}{:>12}{:>18}{:>12}{:>10}{:>14}{:>16}  {}\n", "", "seconds", "frames/s", "slowest-fastest",
            "queries", "cells", "queries/cell", "contacts lost", "hash");
        for (std::size_t i = 0; i < played.size(); ++i) {
            const Window all = played[i].total();
            double least = 1e300, most = 0;
            for (const Window& w : played[i].windows)
                if (w.frames)
                    least = std::min(least, 1e3 * double(w.frames) / w.ms),
                    most = std::max(most, 1e3 * double(w.frames) / w.ms);
            say("{:<22}{:>10.3f}{:>12.0f}{:>18}{:>12}{:>10}{:>14}{:>16}  {:016x}\n", methods_[i].name, all.ms / 1e3,
                1e3 * double(all.frames) / all.ms, fmt::format("{:.0f}-{:.0f}", least, most), grouped(all.queries),
                grouped(all.cells), all.queries ? fmt::format("{:.2f}", double(all.queries) / double(all.cells)) : "-",
                grouped(lost(played.back(), played[i])), played[i].hash);
        }
        say("contacts lost: pairs, over all frames, that cpu, which misses none, leaves over and the method does "
            "not\n\n");
    }

    void print_timeline(const std::vector<Played>& played)
    {
        say("over time: frames per second (queries)\n{:>12}", "to frame");
        for (const Method& method : methods_) say("{:>24}", method.name);
        say("\n");
        std::uint64_t frame = 0;
        for (std::size_t w = 0; w < played.front().windows.size(); ++w) {
            frame += played.front().windows[w].frames;
            say("{:>12}", frame);
            for (std::size_t i = 0; i < played.size(); ++i) {
                const Window& window = played[i].windows[w];
                const double rate = window.frames ? 1e3 * double(window.frames) / window.ms : 0;
                say("{:>24}", window.queries ? fmt::format("{:.0f} ({})", rate, grouped(window.queries))
                                             : fmt::format("{:.0f}", rate));
                if (csv_)
                    csv_->row(2, frame, Quoted{methods_[i].name}, window.frames, window.ms, window.queries,
                              window.cells);
            }
            say("\n");
        }
    }

    PaperOptions options_;
    std::vector<Method> methods_;
    std::optional<CsvFile> csv_;
};

/// The tables of the paper: one level of seven models, and its animation.
int bench_paper(const PaperOptions& options)
{
    check_range("--frames", options.frames.value_or(12), 12);
    check_files({{"--csv", options.csv}});
    check(Settings{.depth = options.depth, .viewport = options.viewport, .age_limit = options.age});
    PaperBench(options).run();
    return 0;
}

} // namespace

void add_paper(Arguments bench)
{
    Arguments sub = bench.add_command("paper", "The paper's tables: its occlusion queries and the other backends");
    auto options = std::make_shared<PaperOptions>();
    sub.add_flag("--large", options->large, "animate models of 5,100 triangles instead of 1,500");
    sub.add_option("--frames", options->frames, "frames of the animation (default 2400, as in the paper)")
        .type_name("N");
    sub.add_option("--depth", options->depth, "depth of the sphere-trees (default 5, as in the paper)").type_name("D");
    sub.add_option("--age", options->age, "frames after which unused cells are dropped (default 60)").type_name("N");
    sub.add_option("--viewport", options->viewport, "pixels per side of a cell (default 16)").type_name("PX");
    sub.add_option("--gpu", options->gpu, "number of the GPU ('oncollide doctor' lists them)").type_name("N");
    sub.add_option("--data", options->data, "folder with meshes/ (default: $ONCOLLIDE_DATA, else ../shared/data)")
        .type_name("DIR");
    sub.add_option("--csv", options->csv, "write one row per figure").type_name("FILE");
    sub.action([options] { return bench_paper(*options); });
}

} // namespace oncollide::tools
