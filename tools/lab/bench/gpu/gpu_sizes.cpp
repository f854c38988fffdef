#include "bench/gpu/gpu_sizes.hpp"

namespace oncollide::tools {
namespace {

Sizes full_sizes()
{
    return {.name = "full",
            .equal = {{"many", 1000, 10}, {"paper", {}, 2400, 4}, {"hard", {}, 3}},
            .exact = {{"many", 1000, 20},
                      {"many", 10000, 12},
                      {"many", 100000, 6},
                      {"paper", {}, 2400, 20},
                      {"city", 20000, 20}},
            .poses = 1'000'000,
            .meshes = {{"paper/lamp.obj", 600},
                       {"paper/bunny.obj", 1500},
                       {"paper/cow_5144.obj", 5144},
                       {"bunny_69k.obj", 69451}},
            .tree_meshes = 2,
            .missed_meshes = 3,
            .rows = {24, 240, 2400, 24000},
            .depths = {5, 6, 7},
            .missed_depth = 6,
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
            .exact = {{"many", 100, 4}, {"paper", {}, 2400, 150}},
            .poses = 1000,
            .meshes = {{"paper/lamp.obj", 600}, {"paper/cow_5144.obj", 5144}},
            .tree_meshes = 1,
            .missed_meshes = 1,
            .rows = {24, 240, 2400},
            .depths = {4, 5},
            .missed_depth = 4,
            .paper = {"paper", {}, 2400, 150},
            .many = {{"many", 100, 4}},
            .comparators = {{"many", 12, 1}, {"hard", {}, 1}},
            .cullide_pixels = 128,
            .repeats = 2,
            .batch_s = 0.2};
}

} // namespace

Sizes sizes_of(const GpuOptions& o, bool software)
{
    if (o.sizes != "auto" && o.sizes != "full" && o.sizes != "small")
        usage(fmt::format("--sizes {}: valid are auto, full, small", o.sizes));
    Sizes sizes = o.sizes == "full" || (o.sizes == "auto" && !software) ? full_sizes() : small_sizes();
    sizes.repeats = o.runs.value_or(sizes.repeats), sizes.batch_s = o.batch_s.value_or(sizes.batch_s);
    const auto replace = [&](Cut& cut) {
        if (!o.scene.empty()) cut = {o.scene};
        if (o.bodies) cut.bodies = o.bodies;
        if (o.frames) cut.frames = o.frames;
        cut.every = o.every.value_or(cut.every);
    };
    if (!o.scene.empty()) sizes.comparators.resize(1), sizes.exact.resize(1), replace(sizes.exact.front());
    if (o.poses) sizes.poses = std::size_t(*o.poses);
    replace(sizes.paper);
    for (Cut& cut : sizes.comparators) replace(cut);
    return sizes;
}

} // namespace oncollide::tools
