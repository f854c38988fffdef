#pragma once
#include <iostream>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "bench/scenes/environment_scenes.hpp"
#include "bench/statistics.hpp"
#include "cli/options.hpp"

#include <oncollide/base/printable.hpp>
#include <oncollide/broadphase/broad_phase.hpp>

// What the benchmarks share. Each runs FCL and oncollide on the same work in one program, turn about, and reports
// ratios.
namespace oncollide::tools {

struct CompareOptions {
    SceneOptions scene;
    SettingsOptions settings;
    int warm_up = 3;       ///< frames at the start that are not counted
    int repeats = 1;       ///< runs from frame 0; of a frame's times the least counts
    int cold_runs = 5;     ///< first frames measured from nothing
    bool contacts = false; ///< every contact of every pair, instead of yes or no; with exact predicates
    int timeline = 0;      ///< print a line every so many frames; 0: none
    std::string only;      ///< "fcl" or "oncollide": measure that one alone
    std::string csv;       ///< one row a frame
    std::string summary;   ///< one row in all
    std::string shard;     ///< of the frames
};

/// Plays a scene with both. Returns the exit code: 70 when oncollide missed a collision.
int bench_scene(const CompareOptions& options);

struct PosesOptions {
    std::string data, depths = "4-8", csv;
    int repeats = 5;
    int poses = 0; ///< at most so many; 0: all
};

/// One pair of meshes in the poses of the data folder.
int bench_poses(const PosesOptions& options);

struct PaperOptions {
    std::string data, csv;
    std::optional<int> frames;
    int gpu = -1, viewport = 16, depth = 5, age = Settings{}.age_limit;
    bool large = false;
};

/// The tables of the paper: one level of seven models, and its animation.
int bench_paper(const PaperOptions& options);

struct OctantsOptions {
    std::string data, only, csv;
    int gpu = -1, repeats = 5;
    double limit_s = 2; ///< batches that would take longer are left out
};

/// Batches of octant queries to every backend.
int bench_octants(const OctantsOptions& options);

struct BroadOptions {
    std::string scene = "brown", sizes, threads, only, csv, plot, shard;
    bool per_box = false; ///< the plot shows nanoseconds a box
    std::optional<int> frames;
    std::uint64_t seed = 12345;
};

/// The broad phase alone, on boxes, beside those of other libraries. Returns the exit code: 70 when oncollide missed a
/// pair or a scene did not give its published pairs.
int bench_broad(const BroadOptions& options);

struct NarrowOptions {
    std::vector<std::string> meshes; ///< none or two files
    bool use_poses = false;          ///< a pose file instead of generated poses
    std::string poses;               ///< that file; empty: the data folder's, with its own meshes
    std::string distances, ask, only, csv, plot, data, shard;
    std::optional<int> count; ///< poses a distance, or of the file
    int repeats = 3;
    std::uint64_t seed = 12345;
};

/// The narrow phase alone, one pair of meshes in many poses, beside those of other libraries. Returns the exit code: 70
/// when oncollide missed a collision or an exact result of it is wrong.
int bench_narrow(const NarrowOptions& options);

struct PlannerOptions {
    std::vector<std::string> meshes; ///< none, or the fixed and the moving one
    int poses = 100'000;
    std::uint64_t seed = 12345;
    std::string csv;
};

/// Many poses of one mesh against another at once, beside FCL in a loop. Returns the exit code: 70 when FCL contradicts
/// an answer.
int bench_planner(const PlannerOptions& options);

struct WorldOptions {
    int bodies = 100'000;
    int changes = 1000; ///< bodies that move, or are removed and added, per frame
    int frames = 20;
    std::uint64_t seed = 12345;
    Settings settings;
    std::string csv;
};

/// What frames of a World cost, by how many bodies change, and queries of it. Returns the exit code: 70 when a World
/// made anew finds other pairs.
int bench_world(const WorldOptions& options);

struct EnvironmentOptions {
    EnvironmentChoice in{.bodies = 500};
    std::string errors = "1,0.1,0.01,exact";
    int frames = 10, warm_up = 3, cold_runs = 1, threads = 1;
    int repeats = 1; ///< of all frames; of each frame the least time counts
    std::string csv, plot, shard;
};

/// Large environments with many bodies, beside FCL. Returns the exit code: 70 when oncollide missed a collision or an
/// exact result of it is wrong.
int bench_environment(const EnvironmentOptions& options);

struct DistancesOptions {
    EnvironmentChoice in{.bodies = 12};
    std::string distances = "0.1,1,5,10,25,50,100,200"; ///< per cent of the environment's diagonal
    double tolerance = 0;                               ///< metres
    int repeats = 3;
    std::string csv, shard;
};

/// Distances of bodies to large environments, beside FCL. Returns the exit code.
int bench_distances(const DistancesOptions& options);

struct ShapesOptions {
    int pairs = 100'000;
    int threads = 0; ///< that judge; both sides are timed on one
    double least_gap = 1e-6;
    std::uint64_t seed = 12345;
    std::string csv;
};

/// Close pairs of shapes of all kinds, beside FCL's libccd. Returns the exit code: 70 when extended precision
/// contradicts a result of oncollide.
int bench_shapes(const ShapesOptions& options);

struct ClashBenchOptions {
    int parts = 5000, triangles = 1000, every = 10, repeats = 1, threads = 2, pictures = 40;
    bool real = false;
    std::string data, write, csv;
};

/// Clash reports of an assembly whose clashes are known, from files to report. Returns the exit code: 70 when a clash
/// was missed, invented or measured wrongly.
int bench_clash(const ClashBenchOptions& options);

struct ReadOptions {
    std::vector<std::string> files; ///< empty: generated ones
    std::string styles;             ///< of the generated ones; empty: all
    int triangles = 10'000'000;
    int repeats = 3;
    std::uint64_t seed = 12345;
    std::string folder; ///< for the generated ones; empty: the system's for temporary files
    std::string csv;
};

/// Reads mesh files of every format. Returns the exit code.
int bench_read(const ReadOptions& options);

/// Regions that delimitation rejected of those that it looked at, level by level below the whole: "0/2 81/112".
std::string regions_text(std::span<const DelimitationLevel> levels);

/// "4-8", "6" or "2,5-7" as ascending numbers; `option` names it in errors. Each 1 to 16.
std::vector<int> parse_depths(const std::string& option, const std::string& text);

/// "2500,10k,1M" as ascending numbers from 1 to `most`; `option` names it in errors.
std::vector<std::size_t> parse_counts(const char* option, const std::string& list, std::size_t most);

/// The parts of a list separated by commas, empty ones too.
std::vector<std::string> split(const std::string& list);

/// Lines that say which program, compiler, peer and machine a result comes from.
std::string describe_program(const std::string& backend);
/// The settings that shape a result, on one line; without the accuracy when `accuracy` stands in for it.
std::string describe(const Settings& settings, const std::string& accuracy = {});

template <class... Args>
void say(fmt::format_string<Args...> format, Args&&... args)
{
    std::cout << printable_lines(fmt::format(format, std::forward<Args>(args)...));
}

/// 1,234,567
std::string grouped(std::uint64_t value);
/// A count's mean over frames: one decimal when small.
std::string mean_count(std::uint64_t sum, std::uint64_t frames);

} // namespace oncollide::tools
