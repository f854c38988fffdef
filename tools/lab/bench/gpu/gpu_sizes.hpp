#pragma once
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <oncollide/pipeline/settings.hpp>

#include "bench/common/benchmark.hpp"

namespace oncollide::tools {

constexpr std::array<std::string_view, 11> gpu_parts{"correctness", "frames",   "batches",    "octants",
                                                     "trees",       "misses",   "levels",     "many",
                                                     "paper",       "timeline", "comparators"};

struct GpuOptions : SharedOptions {
    std::string sizes = "auto";
    std::string parts; ///< empty: all parts
    std::string scene; ///< of frames and of the last three parts; empty: the usual scenes
    std::optional<int> bodies, frames, every, runs;
    std::optional<int> poses;
    int depth = 5, viewport = 16, age = Settings{}.age_limit;
    double limit_s = 420; ///< no measurement begins later
    std::optional<double> batch_s;
    bool all_backends = false;
};

/// A scene, cut to a size.
struct Cut {
    std::string scene;
    std::optional<int> bodies{};
    std::optional<int> frames{};
    int every = 1; ///< frames are played
};

struct Sizes {
    std::string name;
    std::vector<Cut> equal; ///< scenes whose hashes are compared
    std::vector<Cut> exact; ///< scenes of exact frames
    std::size_t poses;      ///< of a batch
    std::vector<std::pair<const char*, int>>
        meshes; ///< of octants; the last ones also of whole trees, the others of misses
    std::size_t tree_meshes, missed_meshes;
    std::vector<std::size_t> rows;
    std::vector<int> depths; ///< of whole trees
    int missed_depth;
    Cut paper;
    std::vector<Cut> many, comparators;
    int cullide_pixels; ///< per side
    int repeats;
    double batch_s; ///< batches predicted to take longer are left out
};

/// The sizes of this name, after the options have replaced some of them. Throws Error{usage} for an unknown name.
Sizes sizes_of(const GpuOptions& options, bool software);

} // namespace oncollide::tools
