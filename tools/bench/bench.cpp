// oncollide bench: one subcommand per benchmark.
#include "bench/bench.hpp"
#include "bench/scenes/bench_scale.hpp"
#include "cli/command.hpp"
#include "cli/shard.hpp"

#include <memory>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide::tools {
namespace {

void add_compare_options(Arguments sub, CompareOptions& o)
{
    add_catalogue_options(sub, o.scene), add_pace_option(sub, o.scene);
    add_cache_options(sub, o.scene.cache);
    add_accuracy_options(sub, o.settings);
    add_pipeline_options(sub, o.settings);
    sub.add_option("--warm-up", o.warm_up, "frames at the start that are not timed (default 3)").type_name("N");
    sub.add_option("--repeats", o.repeats,
                   "number of runs from frame 0; each frame's least time "
                   "counts")
        .type_name("N");
    sub.add_option("--cold-runs", o.cold_runs,
                   "number of cold starts, from the scene to the first frame's results "
                   "(default 5)")
        .type_name("N");
    sub.add_option("--only", o.only, "run only fcl or only oncollide, to measure its memory").type_name("WHO");
    sub.add_flag("--contacts", o.contacts,
                 "find all contacts of each colliding pair, not only whether it collides; needs exact results");
    sub.add_option("--timeline", o.timeline, "print a line every N frames: cells alive, pairs, times").type_name("N");
    sub.add_option("--csv", o.csv, "write one row per frame").type_name("FILE");
    sub.add_option("--summary", o.summary,
                   "write one row: time of the first result, time per frame, "
                   "memory")
        .type_name("FILE");
    sub.add_option("--shard", o.shard, std::string("divide the frames among N processes: ") + shard_help)
        .type_name("I/N");
}

void add_scene_bench(Arguments bench, const char* name, const char* summary)
{
    Arguments sub = bench.add_command(name, summary);
    auto options = std::make_shared<CompareOptions>();
    options->scene.scene = name;
    add_compare_options(sub, *options);
    sub.action([options] { return bench_scene(*options); });
}

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

void add_poses(Arguments bench)
{
    Arguments sub =
        bench.add_command("poses", "One pair of meshes in 1,000 poses with known results (needs the data folder)");
    auto options = std::make_shared<NarrowOptions>();
    options->use_poses = true, options->ask = "boolean", options->depths = "4-8", options->repeats = 5;
    sub.add_option("--data", options->data, "folder with poses/ (default: $ONCOLLIDE_DATA, else ../shared/data)")
        .type_name("DIR");
    sub.add_option("--depths", options->depths, "depths of the sphere-trees (default 4-8)").type_name("LIST");
    sub.add_option("--repeats", options->repeats,
                   "number of runs; each query's least time counts (default "
                   "5)")
        .type_name("N");
    sub.add_option("--poses", options->count, "use only the first N poses").type_name("N");
    sub.add_option("--csv", options->poses_csv, "write one row per pose").type_name("FILE");
    sub.footer(
        "The same as 'oncollide bench narrow --poses --query boolean' with FCL and these depths; each depth also\n"
        "with FCL for the pairs that are left over.");
    sub.action([options] {
        options->only = "fcl-obb,fcl-obbrss";
        for (int depth : parse_depths("--depths", options->depths))
            options->only += fmt::format(",walk-{0},walk-{0}+fcl", depth);
        return bench_narrow(*options);
    });
}

void add_octants(Arguments bench)
{
    Arguments sub = bench.add_command("octants", "Batches of octant queries: which octants does the surface "
                                                 "intersect?");
    auto options = std::make_shared<OctantsOptions>();
    sub.add_option("--data", options->data, "folder with meshes/ (default: $ONCOLLIDE_DATA, else ../shared/data)")
        .type_name("DIR");
    sub.add_option("--gpu", options->gpu, "number of the GPU ('oncollide doctor' lists them)").type_name("N");
    sub.add_option("--repeats", options->repeats,
                   "number of runs; each batch's least time counts (default "
                   "5)")
        .type_name("N");
    sub.add_option("--only", options->only, "run only one part: speed, trees or misses").type_name("PART");
    sub.add_option("--limit", options->limit_s, "skip batches that would take longer (seconds, default 2)")
        .type_name("S");
    sub.add_option("--csv", options->csv, "write one row per figure").type_name("FILE");
    sub.action([options] { return bench_octants(*options); });
}

void add_broad(Arguments bench)
{
    Arguments sub = bench.add_command("broad", "Only the broad phase, on boxes, compared with other libraries");
    auto options = std::make_shared<BroadOptions>();
    sub.add_option("--scene", options->scene,
                   "scenes, or a recording: brown (default), large, mixed, flat, clustered, static, giant, jump, and "
                   "freefall, brownian, gravity with -cubes or -assorted")
        .type_name("LIST|FILE.aabbs");
    sub.add_option("--sizes", options->sizes, "numbers of boxes, such as 2500,10k,1M (default 1k,10k,100k)")
        .type_name("LIST");
    sub.add_option("--frames", options->frames, "frames to play; the first third is not timed (default 60 to 8)")
        .type_name("N");
    sub.add_option("--threads", options->threads, "numbers of threads (default 1)").type_name("LIST");
    sub.add_option("--only", options->only, "run only these contenders").type_name("LIST");
    sub.add_option("--csv", options->csv, "write one row per contender and size").type_name("FILE");
    sub.add_option("--shard", options->shard,
                   std::string("divide the scenes and sizes among N "
                               "processes: ") +
                       shard_help)
        .type_name("I/N");
    Option plot = sub.add_option("--plot", options->plot, "draw time against size, one panel per scene");
    plot.type_name("FILE.svg");
    sub.add_flag("--per-box", options->per_box, "plot nanoseconds per box, to show growth").needs(plot);
    sub.add_option("--seed", options->seed, "seed of the scene (default 12345)").type_name("S");
    sub.action([options] { return bench_broad(*options); });
}

void add_narrow(Arguments bench)
{
    Arguments sub = bench.add_command("narrow", "Only the narrow phase, on two meshes, compared with other libraries");
    auto options = std::make_shared<NarrowOptions>();
    sub.add_option("meshes", options->meshes, "two mesh files; the second is moved (default: two generated knots)")
        .expected(0, 2)
        .type_name("MESH_A MESH_B");
    Option distances = sub.add_option("--distances", options->distances,
                                      "distances of the surfaces, in percent of the diagonal of MESH_A's AABB "
                                      "(default 0,0.1,1,5,10,20,40); 0 just touches, negative collides");
    distances.type_name("LIST");
    Option poses = sub.add_option("--poses", options->poses,
                                  "poses from a file for these meshes, with exact results if FILE_expected exists; "
                                  "without FILE: the data folder's set with its own meshes");
    poses.type_name("FILE").expected(0, 1);
    sub.add_option("--count", options->count, "poses per distance (default 100), or poses of the file (default: all)")
        .type_name("N");
    sub.add_option("--query,--ask", options->ask,
                   "queries: boolean (do they collide?), all (which triangles meet?), distance (default: all three)")
        .type_name("LIST");
    sub.add_option("--only", options->only, "run only these contenders").type_name("LIST");
    sub.add_option("--repeats", options->repeats,
                   "number of runs; each query's least time counts (default "
                   "3)")
        .type_name("N");
    sub.add_option("--csv", options->csv, "write one row per contender, query and distance").type_name("FILE");
    sub.add_option("--shard", options->shard, std::string("divide the distances among N processes: ") + shard_help)
        .type_name("I/N");
    sub.add_option("--plot", options->plot, "draw time against distance, one panel per query").type_name("FILE.svg");
    sub.add_option("--seed", options->seed, "seed of the poses (default 12345)").type_name("S");
    sub.add_option("--data", options->data, "folder with poses/ (default: $ONCOLLIDE_DATA, else ../shared/data)")
        .type_name("DIR");
    sub.footer(
        "Examples:\n"
        "  oncollide bench narrow                                     two generated knots, no files needed\n"
        "  oncollide bench narrow cup.obj spoon.stl --distances 0,1,10 --plot narrow.svg\n"
        "  oncollide bench narrow --poses --query boolean --only walk-6,fcl-obb,fcl-obbrss\n"
        "Every result is checked by exact arithmetic. In 'results', +k are k false positives and\n"
        "MISSED k is k missed collisions (of 'all': pairs of triangles). Exit code 70: oncollide missed a\n"
        "collision, or an exact result is wrong. Definitions for each contender: docs/notes/benchmark-methods.md.");
    sub.action([options, poses] {
        options->use_poses = poses.given();
        return bench_narrow(*options);
    });
}

void add_planner(Arguments bench)
{
    Arguments sub = bench.add_command("planner", "Many sampled poses of one mesh against another, in one call");
    auto options = std::make_shared<PlannerOptions>();
    sub.add_option("meshes", options->meshes, "two mesh files; the second is moved (default: terrain and knot)")
        .expected(0, 2)
        .type_name("STATIC MOVING");
    sub.add_option("--poses", options->poses, "poses to sample (default 100000)").type_name("N");
    sub.add_option("--seed", options->seed, "seed of the poses (default 12345)").type_name("S");
    sub.add_option("--csv", options->csv, "write one row per kind of query and number of threads").type_name("FILE");
    sub.footer("The first call includes building FCL's models and oncollide's trees. Ratios compare second calls.\n"
               "'false': poses that oncollide leaves over and FCL finds separate.");
    sub.action([options] { return bench_planner(*options); });
}

void add_rays(Arguments bench)
{
    Arguments sub = bench.add_command("rays", "Segments against a mesh, a terrain and a map");
    auto options = std::make_shared<RaysOptions>();
    sub.add_option("mesh", options->mesh, "mesh file (default: generated hills, and a building)").type_name("FILE");
    sub.add_option("--triangles", options->triangles, "approximate triangles of the hills (default 500000)")
        .type_name("N");
    sub.add_option("--rays", options->rays, "number of segments of each kind (default 10000)").type_name("N");
    sub.add_option("--repeats", options->repeats, "number of runs; the fastest counts (default 3)").type_name("N");
    sub.add_option("--seed", options->seed, "seed of the hills and the segments (default 12345)").type_name("S");
    sub.add_option("--csv", options->csv, "write one row per contender and kind of segment").type_name("FILE");
    sub.footer("slanted: down through the height of the box, in any direction, 0.37 to 0.42 of its diagonal long;\n"
               "vertical: from top to bottom; short: a hundredth of the diagonal, anywhere.\n"
               "Exit code 70: oncollide missed or invented a hit.");
    sub.action([options] { return bench_rays(*options); });
}

void add_world(Arguments bench)
{
    Arguments sub = bench.add_command("world", "Bodies that are added, removed and moved between frames, and queries");
    auto options = std::make_shared<WorldOptions>();
    auto settings = std::make_shared<SettingsOptions>();
    sub.add_option("--bodies", options->bodies, "bodies (default 100000)").type_name("N");
    sub.add_option("--changes", options->changes, "bodies moved, or removed and added, per frame (default 1000)")
        .type_name("N");
    sub.add_option("--frames", options->frames, "frames to time (default 20)").type_name("N");
    sub.add_option("--seed", options->seed, "seed of the scene (default 12345)").type_name("S");
    sub.add_option("--csv", options->csv, "write one row per kind of change").type_name("FILE");
    add_accuracy_options(sub, *settings);
    add_pipeline_options(sub, *settings);
    sub.footer("A newly made World must give the same results. Exit code 70: they differ.");
    sub.action([options, settings] {
        options->settings = settings_from(*settings);
        return bench_world(*options);
    });
}

/// Adds the options; defaults are taken from `in`.
void add_environment_choice(Arguments sub, EnvironmentChoice& in)
{
    sub.add_option(
           "--environments", in.environments,
           "environments (default building,hills,hills-mesh): building, a map of 30 x 30 rooms at 6 cm; hills, a "
           "height grid; hills-mesh, the same as a mesh; campus and st-helens, from the data folder; or one shape of "
           "about a metre: sphere, box, capsule, cylinder, hull, ellipsoid, cone")
        .type_name("LIST");
    sub.add_option("--bodies-of", in.bodies_of,
                   "meshes, shapes (spheres, boxes and capsules), all-shapes (all bounded kinds), both, or a list "
                   "(default meshes,shapes)")
        .type_name("LIST");
    sub.add_option("--bodies", in.bodies, fmt::format("bodies in each environment (default {})", in.bodies))
        .type_name("N");
    sub.add_option("--cells", in.cells,
                   "cells along a side of the hills (default 500; 2200 give 9.7 million triangles)")
        .type_name("N");
    sub.add_option("--seed", in.seed, "seed of environments and bodies (default 1)").type_name("S");
    sub.add_option("--data", in.data, "data folder (default: $ONCOLLIDE_DATA, else ../shared/data if present)")
        .type_name("DIR");
}

void add_distances(Arguments bench)
{
    Arguments sub = bench.add_command("distances", "Distances of bodies to buildings and terrains, near and far");
    auto options = std::make_shared<DistancesOptions>();
    add_environment_choice(sub, options->in);
    sub.add_option("--distances", options->distances,
                   "in percent of the environment's diagonal (default 0.1,1,5,10,25,50,100,200)")
        .type_name("LIST");
    sub.add_option("--tolerance", options->tolerance,
                   "largest difference of oncollide's bounds in metres (default 0); FCL's error for shapes is up to "
                   "1e-6")
        .length();
    sub.add_option("--repeats", options->repeats,
                   "number of runs; each query's least time counts (default "
                   "3)")
        .type_name("N");
    sub.add_option("--csv", options->csv, "write one row per environment, bodies and distance").type_name("FILE");
    sub.add_option("--shard", options->shard,
                   std::string("divide the environments with their bodies among N "
                               "processes: ") +
                       shard_help)
        .type_name("I/N");
    sub.footer("Examples:\n"
               "  oncollide bench distances --environments hills --distances 1,10,100 --bodies 30\n"
               "  oncollide bench distances --environments campus --bodies-of shapes --csv distances.csv");
    sub.action([options] { return bench_distances(*options); });
}

void add_environment(Arguments bench)
{
    Arguments sub = bench.add_command("environment", "Many bodies in buildings and on terrains, with several error "
                                                     "bounds");
    auto options = std::make_shared<EnvironmentOptions>();
    add_environment_choice(sub, options->in);
    sub.add_option("--errors", options->errors,
                   "error bounds in metres, and 'exact' (default "
                   "1,0.1,0.01,exact)")
        .type_name("LIST");
    sub.add_option("--frames", options->frames, "frames to play (default 10)").type_name("N");
    sub.add_option("--warm-up", options->warm_up, "frames at the start that are not timed (default 3)").type_name("N");
    sub.add_option("--repeats", options->repeats, "number of runs; each frame's least time counts (default 1)")
        .type_name("N");
    sub.add_option("--cold-runs", options->cold_runs, "number of cold starts (default 1)").type_name("N");
    sub.add_option("--threads", options->threads, "threads of oncollide; 0: all (default 1)").type_name("N");
    sub.add_option("--csv", options->csv, "write one row per environment, bodies and error").type_name("FILE");
    sub.add_option("--shard", options->shard,
                   std::string("divide the environments with their bodies among N "
                               "processes: ") +
                       shard_help)
        .type_name("I/N");
    sub.add_option("--plot", options->plot, "draw time against error, one panel per environment").type_name("FILE.svg");
    sub.footer("Examples:\n"
               "  oncollide bench environment --environments building --bodies 50 --errors 0.1,exact\n"
               "  oncollide bench environment --environments hills,hills-mesh --cells 2200 --bodies 1000\n"
               "'first': from the geometry in memory to the first frame's results. Exit code 70: a collision was\n"
               "missed, or an exact result is wrong.");
    sub.action([options] { return bench_environment(*options); });
}

void add_clash_bench(Arguments bench)
{
    Arguments sub = bench.add_command("clash", "Clash reports of an assembly with known clashes, from files to report");
    auto options = std::make_shared<ClashBenchOptions>();
    sub.add_option("--parts", options->parts, "number of parts of the assembly (default 5000)").type_name("N");
    sub.add_option("--triangles", options->triangles, "triangles per part (default 1000)").type_name("N");
    sub.add_flag("--real", options->real, "use the data folder's meshes of up to 20,000 triangles");
    sub.add_option("--every", options->every, "every N-th site has a planted pair (default 10)").type_name("N");
    sub.add_option("--threads", options->threads, "number of threads; 0: all (default 2)").type_name("N");
    sub.add_option("--repeats", options->repeats, "number of runs; the fastest counts (default 1)").type_name("N");
    sub.add_option("--pictures", options->pictures,
                   "number of clashes to draw in the page (default "
                   "40)")
        .type_name("N");
    sub.add_option("--data", options->data, "folder with meshes/ (default: $ONCOLLIDE_DATA, else ../shared/data)")
        .type_name("DIR");
    sub.add_option("--write", options->write, "keep the assembly and its reports in this folder").type_name("FOLDER");
    sub.add_option("--csv", options->csv, "write one row per kind of file").type_name("FILE");
    sub.footer("Planted pairs cross deeply or barely, touch, are near or slightly too far, are enclosed, or lie free "
               "in\n"
               "a hollow or a ring. Exit code 70: a clash was missed, invented or measured\n"
               "wrongly.");
    sub.action([options] { return bench_clash(*options); });
}

void add_shapes(Arguments bench)
{
    Arguments sub = bench.add_command("shapes", "Pairs of shapes close to contact, checked in extended precision");
    auto options = std::make_shared<ShapesOptions>();
    sub.add_option("--pairs", options->pairs, "number of random pairs (default 100000)").type_name("N");
    sub.add_option("--seed", options->seed, "seed of the pairs (default 12345)").type_name("S");
    sub.add_option("--least-gap", options->least_gap, "least gap or overlap; 0.1 m is the largest (default 1e-6)")
        .length();
    sub.add_option("--threads", options->threads,
                   "number of threads for the checks; 0: all (default "
                   "0)")
        .type_name("N");
    sub.add_option("--csv", options->csv, "write one row per pair of kinds").type_name("FILE");
    sub.footer(
        "Both libraries are timed on one thread, in alternation. 'within': pairs that oncollide does not decide; 'FCL "
        "lost' and 'FCL made': collisions that FCL misses, and false collisions of FCL; 'worst': largest distance "
        "of such a pair. Exit code 70: the truth contradicts a result or a bound of oncollide.");
    sub.action([options] { return bench_shapes(*options); });
}

void add_read(Arguments bench)
{
    Arguments sub = bench.add_command("read", "Reading mesh files: triangles per second and memory, by format");
    auto options = std::make_shared<ReadOptions>();
    sub.add_option("files", options->files,
                   "mesh files, or scene files, whose bodies are counted (default: a generated height field in each "
                   "style)")
        .expected(0, 1000)
        .type_name("FILE...");
    sub.add_option("--styles", options->styles,
                   "styles of the generated files: obj, obj-full, obj-back, obj-exact, stl, stl-mixed, ply, stl-text, "
                   "ply-text, off (default: all)")
        .type_name("LIST");
    sub.add_option("--triangles", options->triangles,
                   "approximate triangles of the height field (default "
                   "10000000)")
        .type_name("N");
    sub.add_option("--repeats", options->repeats,
                   "number of runs; each file's least time counts (default "
                   "3)")
        .type_name("N");
    sub.add_option("--seed", options->seed, "seed of the heights (default 12345)").type_name("S");
    sub.add_option("--folder", options->folder, "folder for the generated files (default: $TMPDIR)").type_name("DIR");
    sub.add_option("--csv", options->csv, "write one row per file").type_name("FILE");
    sub.footer("'ms' is processor time of the thread, 'wall ms' elapsed time: reading from the system's cache, checks, "
               "welding (STL).\n"
               "'peak MB' is the largest growth of the process, 'bytes each' the same per triangle.");
    sub.action([options] { return bench_read(*options); });
}

void add_scale(Arguments bench)
{
    Arguments sub = bench.add_command("scale", "Ranks of a large world, simulated one after another, compared with a "
                                               "cost model");
    auto options = std::make_shared<ScaleOptions>();
    sub.add_option("--bodies", options->bodies,
                   "approximate number of bodies in the world, a cube of cells (default "
                   "1e6)")
        .type_name("N");
    sub.add_option("--ranks", options->ranks, "numbers of ranks to compare (default 64)").type_name("LIST");
    sub.add_option("--sample", options->sample, "number of ranks to play; 0: all (default 0)").type_name("N");
    sub.add_option("--edge", options->edge, "mean edge of the bodies, in mean spacings (default 1)").type_name("E");
    sub.add_option("--frame", options->frame, "frame of the motion (default 0)").type_name("F");
    sub.add_option("--threads", options->threads,
                   "ranks played at the same time; 0: as many as processors (default "
                   "1)")
        .type_name("N");
    sub.add_option("--seed", options->seed, "seed of the bodies (default 12345)").type_name("S");
    sub.add_option("--csv", options->csv, "write one row per rank").type_name("FILE");
    sub.add_option("--shard", options->shard, std::string("divide the ranks among N processes: ") + shard_help)
        .type_name("I/N");
    sub.footer("If all ranks are played, pairs and hash do not depend on the number of ranks. Exit code 70: they do,\n"
               "or the number of ghosts differs from the model by more than a tenth.\n"
               "  oncollide bench scale --ranks 8,64 --bodies 1e6\n"
               "  oncollide bench scale --ranks 10000 --bodies 1e9 --sample 26");
    sub.action([options] { return bench_scale(*options); });
}

} // namespace

void add_bench(Arguments app)
{
    Arguments bench =
        app.add_command("bench", "Measure oncollide and other libraries in one run, on the same workload, in "
                                 "alternation");
    bench.at_most_one_command();
    bench.action([]() -> int {
        usage("bench: choose a benchmark: broad, narrow, planner, rays, world, environment, distances, shapes, clash, "
              "read, "
              "scale, many, octants, paper, poses or scene (oncollide bench --help)");
    });
    add_broad(bench);
    add_narrow(bench);
    add_planner(bench);
    add_rays(bench);
    add_world(bench);
    add_environment(bench);
    add_distances(bench);
    add_shapes(bench);
    add_clash_bench(bench);
    add_read(bench);
    add_scene_bench(bench, "many", "Bunnies, dragons and cows in a cube");
    add_paper(bench);
    add_poses(bench);
    add_octants(bench);
    add_scale(bench);
    Arguments scene = bench.add_command("scene", "Any scene: a file or a scene of the catalogue");
    auto options = std::make_shared<CompareOptions>();
    scene.add_option("scene", options->scene.scene, "scene file, or a name from 'oncollide scene --list'")
        .required()
        .type_name("SCENE.json|NAME");
    add_compare_options(scene, *options);
    scene.action([options] { return bench_scene(*options); });
    bench.footer(
        "Examples:\n"
        "  oncollide bench many --bodies 1000 --exact fcl\n"
        "  oncollide bench scene paper-5k --depth 5 --repeats 3 --timeline 100\n"
        "  oncollide bench poses --depths 5-7\n"
        "  oncollide bench broad --scene brown,static --sizes 1k,10k,100k --threads 1,2 --plot broad.svg\n"
        "  oncollide bench narrow cup.obj spoon.stl --distances 0,1,10 --plot narrow.svg\n"
        "For reading and repeating results see docs/notes/benchmark-methods.md. Exit code 70: a collision was missed.");
}

} // namespace oncollide::tools
