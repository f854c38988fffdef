// oncollide-lab bench paper: the paper's tables, with its method, with oncollide's other backends, and with comparators
// of its related work.
#include "bench/bench.hpp"
#include "bench/paper/octant_levels.hpp"
#include "bench/paper/paper_methods.hpp"
#include "cli/options.hpp"
#include "common/text.hpp"

#include <algorithm>
#include <memory>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/narrowphase/gl/gpu.hpp>

namespace oncollide::tools {
namespace {

struct PaperOptions {
    std::string scene = "paper", data, csv;
    std::optional<int> bodies, frames;
    int gpu = -1, viewport = 16, depth = 5, age = Settings{}.age_limit;
    int every = 24;     ///< frames are played with comparators
    bool large = false; ///< the scene paper-5k
};

class PaperBench {
public:
    explicit PaperBench(const PaperOptions& options)
        : options_(options), scene_(open_scene({.scene = options.scene,
                                                .bodies = options.bodies,
                                                .frames = options.frames,
                                                .seed = {},
                                                .data = options.data,
                                                .cache = {}})),
          methods_(tree_methods(options.gpu, options.viewport)),
          csv_(options.csv, "table,what,backend,frames,ms,queries,cells,candidates,left_over,missed,collisions")
    {
    }

    void run()
    {
        const GpuInfo gpu = describe_gpu(options_.gpu);
        say("{}GPU        {}, OpenGL {}; {} pixels per side, samples passed\n\n",
            describe_program(make_cpu_backend()->name()), gpu.renderer, gpu.version, options_.viewport);
        const bool paper = options_.scene == "paper" || options_.scene == "paper-5k";
        if (paper) table_1();
        play_all(paper);
        csv_.commit();
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
        for (const auto& [file, triangles] : level_models()) {
            const NamedMesh mesh = mesh_or_knot(data, file, triangles);
            const OctantLevels levels(mesh.mesh, 1);
            std::string times;
            std::uint64_t queries = 0;
            for (const Method& method : methods_) {
                const auto [ms, work] = one_level(levels, method);
                queries = std::max(queries, work.queries);
                times += fmt::format("{:>21.4f}", ms);
                csv_.row(1, mesh.name, Quoted{method.name}, std::nullopt, ms, work.queries, 1, std::nullopt,
                         std::nullopt, std::nullopt, std::nullopt);
            }
            say("{:<16}{:>10}{:>9}{}\n", mesh.name, grouped(mesh.mesh.triangles.size()), queries, times);
        }
        say("\n");
    }

    /// The paper's Tables 2 and 3; then the comparators, on every n-th frame.
    void play_all(bool paper)
    {
        say("{}{}, {} frames, depth {}, cells dropped after {} frames\n", paper ? "Tables 2 and 3: " : "",
            options_.scene, scene_.frames, options_.depth, options_.age);
        if (paper)
            say("(the paper: 1,500 triangles per model, on a notebook of 2004: 8.58 s with soup, 7.36 s with strips, "
                "178 "
                "to 349 frames per second)\n");
        print_timeline(methods_, play_methods(methods_, 1, 2));

        std::vector<Method> all = comparators(options_.gpu);
        all.insert(all.end(), methods_.end() - 3, methods_.end()); // one of gl-query, gl-compute, cpu
        say("\ncomparators: every {}th frame\n", options_.every);
        play_methods(all, options_.every, 3);
    }

    /// Plays the methods and prints their totals. The last method must be the cpu.
    std::vector<Played> play_methods(const std::vector<Method>& methods, int every, int table)
    {
        const Settings settings{.depth = options_.depth, .age_limit = options_.age};
        std::vector<Played> played;
        for (const Method& method : methods)
            played.push_back(play(scene_, settings, method, std::min(12, scene_.frames), every));
        print_totals(methods, played, true_pairs(scene_, every), table);
        return played;
    }

    void print_totals(const std::vector<Method>& all, const std::vector<Played>& played, const PairsByFrame& truth,
                      int table)
    {
        const std::uint64_t collisions = count_pairs(truth);
        say("{:<22}{:>10}{:>12}{:>18}{:>12}{:>10}{:>14}{:>12}{:>10}{:>10}  {}\n", "", "seconds", "frames/s",
            "slowest-fastest", "queries", "cells", "queries/cell", "left over", "lost", "missed", "hash");
        for (std::size_t i = 0; i < all.size(); ++i) {
            const Window sum = played[i].total();
            const bool trees = bool(all[i].backend);
            double least = 1e300, most = 0;
            for (const Window& w : played[i].windows)
                if (w.frames)
                    least = std::min(least, 1e3 * double(w.frames) / w.ms),
                    most = std::max(most, 1e3 * double(w.frames) / w.ms);
            const std::uint64_t lost = missed(truth, played[i].left);
            say("{:<22}{:>10.3f}{:>12.0f}{:>18}{:>12}{:>10}{:>14}{:>12}{:>10}{:>10}  {:016x}\n", all[i].name,
                sum.ms / 1e3, 1e3 * double(sum.frames) / sum.ms, fmt::format("{:.0f}-{:.0f}", least, most),
                grouped(sum.queries), grouped(sum.cells),
                sum.queries && trees ? fmt::format("{:.2f}", double(sum.queries) / double(sum.cells)) : "-",
                grouped(played[i].left_over()), trees ? grouped(missed(played.back().left, played[i].left)) : "-",
                grouped(lost), played[i].hash);
            if (table == 3)
                csv_.row(table, Quoted{options_.scene}, Quoted{all[i].name}, sum.frames, sum.ms, sum.queries, sum.cells,
                         played[i].candidates, played[i].left_over(), lost, collisions);
            if (lost && all[i].certified)
                throw Error(ErrorKind::internal, fmt::format("{}: {} collisions were missed", all[i].name, lost));
        }
        say("left over: of {} pairs whose boxes overlap, over all frames; lost: pairs that cpu leaves over and the "
            "method "
            "does not;\nmissed: of {} pairs that collide by exact arithmetic\n\n",
            grouped(played.front().candidates), grouped(collisions));
    }

    void print_timeline(const std::vector<Method>& all, const std::vector<Played>& played)
    {
        say("over time: frames per second (queries)\n{:>12}", "to frame");
        for (const Method& method : all) say("{:>24}", method.name);
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
                csv_.row(2, frame, Quoted{all[i].name}, window.frames, window.ms, window.queries, window.cells,
                         std::nullopt, std::nullopt, std::nullopt, std::nullopt);
            }
            say("\n");
        }
    }

    PaperOptions options_;
    Scene scene_;
    std::vector<Method> methods_;
    CsvFile csv_;
};

/// Returns the exit code: 70 if a method that promises not to missed a collision.
int bench_paper(const PaperOptions& options)
{
    check_range("--frames", options.frames.value_or(1), 1);
    check_range("--every", options.every, 1);
    check_files({{"--csv", options.csv}});
    check(Settings{.depth = options.depth, .viewport = options.viewport, .age_limit = options.age});
    PaperBench(options).run();
    return 0;
}

} // namespace

void add_paper(Arguments bench)
{
    Arguments sub = bench.add_command("paper", "The paper's tables: its occlusion queries, the other backends, and "
                                               "comparators (CULLIDE, viewing volumes)");
    auto options = std::make_shared<PaperOptions>();
    sub.add_flag("--large", options->large, "animate models of 5,100 triangles instead of 1,500");
    sub.add_option("--scene SCENE", options->scene,
                   "animate another scene: a file, or a name from 'oncollide scene --list'");
    sub.add_option("--bodies N", options->bodies, "number of bodies of that scene");
    sub.add_option("--frames N", options->frames, "frames of the animation (default 2400, as in the paper)");
    sub.add_option("--every N", options->every, "play the comparators on every N-th frame (default 24)");
    sub.add_option("--depth D", options->depth, "depth of the sphere-trees (default 5, as in the paper)");
    sub.add_option("--age N", options->age, "frames after which unused cells are dropped (default 60)");
    sub.add_option("--viewport PX", options->viewport, "pixels per side of a cell (default 16)");
    sub.add_option("--gpu N", options->gpu, "number of the GPU ('oncollide doctor' lists them)");
    sub.add_option("--data DIR", options->data, "folder with meshes/ (default: $ONCOLLIDE_DATA, else ../shared/data)");
    sub.add_option("--csv FILE", options->csv, "write one row per figure");
    sub.action([options] {
        if (options->large) options->scene = "paper-5k";
        return bench_paper(*options);
    });
}

} // namespace oncollide::tools
