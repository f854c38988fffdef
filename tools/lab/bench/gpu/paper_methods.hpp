#pragma once
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <oncollide/narrowphase/gl/culling/pair_culling.hpp>
#include <oncollide/narrowphase/spheres/occlusion_backend.hpp>
#include <oncollide/runs/pipeline.hpp>

#include "bench/gpu/octant_levels.hpp"

namespace oncollide::tools {

/// Sphere-trees on a backend, or a comparator in their place.
struct Method {
    std::string name;
    std::function<std::unique_ptr<OcclusionBackend>()> backend; ///< empty: a comparator
    std::function<std::unique_ptr<PairCulling>()> culling;      ///< empty: sphere-trees
    bool certified;                                             ///< it promises to miss no collision

    World make(Settings settings) const;
};

/// The paper's method and oncollide's backends; the first is the cpu.
std::vector<Method> tree_methods(int gpu, int viewport);
std::vector<Method> comparators(int gpu, int viewport = CullideOptions{}.viewport); ///< viewport: of CULLIDE

/// A part of the animation.
struct Window {
    double ms = 0;
    std::uint64_t frames = 0, queries = 0, cells = 0;
};

/// Pairs of each frame, sorted.
using PairsByFrame = std::vector<std::vector<BodyPair>>;

struct Played {
    std::vector<Window> windows;
    PairsByFrame left; ///< pairs that are not separate
    std::uint64_t candidates = 0, hash = 0;
    bool stopped = false; ///< not all frames were played

    Window total() const;
    std::pair<double, double> least_and_most_per_s() const; ///< of the windows: frames per second
    std::uint64_t left_over() const;
};

/// Plays every `every`-th frame of a scene with a method, until stop() returns true.
Played play(Scene scene, const Settings& settings, const Method& method, int windows = 12, int every = 1,
            const std::function<bool()>& stop = {});

/// The models of the paper's Table 1, with the number of triangles of their substitutes.
std::span<const std::pair<const char*, int>> level_models();
/// The root's eight octants with a method that has a backend; the least time of ten, ms.
std::pair<double, BatchWork> one_level(const OctantLevels& levels, const Method& method);

/// The pairs that collide in each of these frames, by exact arithmetic that shares no code with the library.
PairsByFrame true_pairs(Scene scene, int every = 1);

/// Number of pairs of `truth`, over all frames, that are not in `pairs`.
std::uint64_t missed(const PairsByFrame& truth, const PairsByFrame& pairs);
std::uint64_t count_pairs(const PairsByFrame& pairs);

} // namespace oncollide::tools
