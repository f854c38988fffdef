#pragma once
#include <optional>
#include <string>
#include <vector>

#include "bench/scenes/environment_scenes.hpp"
#include "cli/options.hpp"
#include "common/text.hpp"

// Common parts of the benchmarks. Each runs FCL and oncollide on the same workload in one program, in alternation, and
// reports ratios.
namespace oncollide::tools {

struct CompareOptions {
    SceneOptions scene;
    SettingsOptions settings;
    int warm_up = 3;       ///< frames at the start that are not timed
    int repeats = 1;       ///< runs from frame 0; the least time of each frame counts
    int cold_runs = 5;     ///< cold starts, from the scene to the first frame's results
    bool contacts = false; ///< find all contacts of each pair; with exact predicates
    int timeline = 0;      ///< frames between printed lines; 0: none
    std::string only;      ///< "fcl" or "oncollide": measure only that library
    std::string csv;       ///< one row per frame
    std::string summary;   ///< a single row
    std::string shard;     ///< of the frames
};

/// Plays a scene with both libraries. Returns the exit code: 70 if oncollide missed a collision.
int bench_scene(const CompareOptions& options);

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
    double limit_s = 2; ///< batches that would take longer are skipped
};

/// Batches of octant queries with every backend.
int bench_octants(const OctantsOptions& options);

struct BroadOptions {
    std::string scene = "brown", sizes, threads, only, csv, plot, shard;
    bool per_box = false; ///< the plot shows nanoseconds per box
    std::optional<int> frames;
    std::uint64_t seed = 12345;
};

/// Compares only the broad phase, on boxes, with other libraries. Returns the exit code: 70 if oncollide missed a pair
/// or a scene did not give its published pairs.
int bench_broad(const BroadOptions& options);

struct NarrowOptions {
    std::vector<std::string> meshes; ///< none or two files
    bool use_poses = false;          ///< a pose file instead of generated poses
    std::string poses;               ///< that file; empty: the set in the data folder, with its own meshes
    std::string distances, ask, only, csv, plot, data, shard;
    std::string depths;       ///< of the sphere-trees, each also followed by FCL; empty: the usual ones
    std::string poses_csv;    ///< one row per pose, with the times of boolean queries
    std::optional<int> count; ///< poses per distance, or poses of the file
    int repeats = 3;
    std::uint64_t seed = 12345;
};

/// Compares only the narrow phase, with one pair of meshes in many poses, with other libraries. Returns the exit code:
/// 70 if oncollide missed a collision or one of its exact results is wrong.
int bench_narrow(const NarrowOptions& options);

struct PlannerOptions {
    std::vector<std::string> meshes; ///< none, or the static and the moving mesh
    int poses = 100'000;
    std::uint64_t seed = 12345;
    std::string csv;
};

/// Many poses of one mesh against another in one call, compared with FCL in a loop. Returns the exit code: 70 if FCL
/// contradicts a result.
int bench_planner(const PlannerOptions& options);

struct RaysOptions {
    std::string mesh; ///< file; empty: generated hills and a building
    int triangles = 500'000;
    int rays = 10'000; ///< of each kind
    int repeats = 3;   ///< the fastest counts
    std::uint64_t seed = 12345;
    std::string csv;
};

/// Segments against a mesh, a terrain and a map, compared with Embree, Bullet and OctoMap. Returns the exit code: 70 if
/// a result of oncollide is wrong.
int bench_rays(const RaysOptions& options);

struct WorldOptions {
    int bodies = 100'000;
    int changes = 1000; ///< bodies that move, or are removed and added, per frame
    int frames = 20;
    std::uint64_t seed = 12345;
    Settings settings;
    std::string csv;
};

/// Cost of a World's frames, by the number of changed bodies, and of its queries. Returns the exit code: 70 if a newly
/// made World finds other pairs.
int bench_world(const WorldOptions& options);

struct EnvironmentOptions {
    EnvironmentChoice in{.bodies = 500};
    std::string errors = "1,0.1,0.01,exact";
    int frames = 10, warm_up = 3, cold_runs = 1, threads = 1;
    int repeats = 1; ///< runs over all frames; the least time of each frame counts
    std::string csv, plot, shard;
};

/// Large environments with many bodies, compared with FCL. Returns the exit code: 70 if oncollide missed a collision or
/// one of its exact results is wrong.
int bench_environment(const EnvironmentOptions& options);

struct DistancesOptions {
    EnvironmentChoice in{.bodies = 12};
    std::string distances = "0.1,1,5,10,25,50,100,200"; ///< percent of the environment's diagonal
    double tolerance = 0;                               ///< metres
    int repeats = 3;
    std::string csv, shard;
};

/// Distances of bodies to large environments, compared with FCL. Returns the exit code.
int bench_distances(const DistancesOptions& options);

struct ShapesOptions {
    int pairs = 100'000;
    int threads = 0; ///< for the checks; both libraries are timed on one thread
    double least_gap = 1e-6;
    std::uint64_t seed = 12345;
    std::string csv;
};

/// Close pairs of shapes of all kinds, compared with FCL's libccd. Returns the exit code: 70 if extended precision
/// contradicts a result of oncollide.
int bench_shapes(const ShapesOptions& options);

struct ClashBenchOptions {
    int parts = 5000, triangles = 1000, every = 10, repeats = 1, threads = 2, pictures = 40;
    bool real = false;
    std::string data, write, csv;
};

/// Clash reports of an assembly with known clashes, from files to report. Returns the exit code: 70 if a clash was
/// missed, invented or measured wrongly.
int bench_clash(const ClashBenchOptions& options);

struct ReadOptions {
    std::vector<std::string> files; ///< empty: generated files
    std::string styles;             ///< styles of the generated files; empty: all
    int triangles = 10'000'000;
    int repeats = 3;
    std::uint64_t seed = 12345;
    std::string folder; ///< for generated files; empty: the system's temporary folder
    std::string csv;
};

/// Reads mesh files of every format. Returns the exit code.
int bench_read(const ReadOptions& options);

} // namespace oncollide::tools
