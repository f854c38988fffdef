// oncollide-lab bench deform: a mesh whose vertices move, against another one, compared with refitted trees.
#include "bench/common/benchmark.hpp"
#include "bench/narrow/cloths.hpp"
#include "peers/peers.hpp"

#include <algorithm>
#include <cstring>

#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide::tools {
namespace {

struct DeformOptions : SharedOptions {
    int triangles = 100'000, frames = 40;
};

using TrianglePairs = std::vector<TrianglePair>;

struct Measured {
    double update_ms = 0, query_ms = 0; ///< per frame
    std::vector<TrianglePairs> pairs;   ///< by frame, sorted
    double refitted = 0;                ///< boxes fitted anew in a frame, as a share of all
    double bytes = 0;                   ///< per triangle; 0: unknown
};

/// Plays the frames once; the first frame is not timed.
Measured play(const DeformContender& contender, const ClothScene& scene)
{
    const Mesh a = scene.mesh(0, 0), b = scene.mesh(1, 0);
    const std::unique_ptr<DeformPeer> peer = contender.make(a, b);
    Measured measured;
    std::uint64_t refitted = 0;
    for (int frame = 0; frame <= scene.frames(); ++frame) {
        if (frame == 1) measured.update_ms = measured.query_ms = 0, refitted = peer->boxes_refitted();
        const double begin = processor_ms();
        for (int which = 0; which < scene.deforming(); ++which) peer->set_vertices(which, scene.vertices(which, frame));
        const double updated = processor_ms();
        TrianglePairs found;
        peer->all_pairs(found);
        const double end = processor_ms();
        measured.update_ms += updated - begin, measured.query_ms += end - updated;
        std::ranges::sort(found);
        measured.pairs.push_back(std::move(found));
    }
    measured.update_ms /= scene.frames(), measured.query_ms /= scene.frames();
    measured.bytes = double(peer->bytes()) / double(a.triangles.size());
    if (const double boxes = double(peer->boxes()) * scene.frames())
        measured.refitted = double(peer->boxes_refitted() - refitted) / boxes;
    return measured;
}

/// Milliseconds of a copy of the vertices that deform, per frame.
double copy_ms(const ClothScene& scene)
{
    std::vector<Eigen::Vector3d> to(scene.vertices(0, 0).size());
    const double begin = processor_ms();
    for (int frame = 1; frame <= scene.frames(); ++frame)
        for (int which = 0; which < scene.deforming(); ++which) {
            const std::span<const Eigen::Vector3d> from = scene.vertices(which, frame);
            std::memcpy(static_cast<void*>(to.data()), from.data(), from.size_bytes());
            asm volatile("" : : "r"(to.data()) : "memory"); // the copy is used
        }
    return (processor_ms() - begin) / scene.frames();
}

void take_least(Measured& least, const Measured& now, bool first)
{
    const bool less = first || now.update_ms + now.query_ms < least.update_ms + least.query_ms;
    const double update = first ? now.update_ms : std::min(least.update_ms, now.update_ms);
    if (less) least = now;
    least.update_ms = std::min(least.update_ms, update);
}

/// Returns the exit code: 70 if exact contenders find different pairs.
int bench_deform(const DeformOptions& options)
{
    DeformContenders contenders = all_contenders().deform;
    contenders.keep(options.only);
    say("{}", describe_program("cpu"));
    print_missing(contenders.missing);
    say("one thread, processor time per frame; least of {} runs of {} frames, of which the first is not timed.\n",
        options.repeats, options.frames + 1);
    ResultTable table(options.csv, {16, 15});
    bool wrong = false;
    for (const ClothScene& scene : cloth_scenes(options.triangles, options.frames)) {
        std::vector<Measured> results(contenders.all.size());
        double copy = 0;
        for (int run = 0; run < options.repeats; ++run) {
            const double ms = copy_ms(scene);
            copy = run ? std::min(copy, ms) : ms;
            for (std::size_t c = 0; c < results.size(); ++c)
                take_least(results[c], play(contenders.all[c], scene), run == 0);
        }
        for (std::size_t c = 0; c < results.size(); ++c) {
            const Measured &r = results[c], &first = results[0];
            std::size_t pairs = 0, others = 0;
            for (std::size_t frame = 0; frame < r.pairs.size(); ++frame) {
                TrianglePairs different;
                std::ranges::set_symmetric_difference(r.pairs[frame], first.pairs[frame],
                                                      std::back_inserter(different));
                pairs += r.pairs[frame].size(), others += different.size();
            }
            wrong |= contenders.all[c].promise == Promise::exact && others > 0;
            const double ms = r.update_ms + r.query_ms;
            table.row(figures("scene", scene.name(), "contender", contenders.all[c].name, "update_ms", r.update_ms,
                              "query_ms", r.query_ms, "ms", ms, "ratio", ms / (first.update_ms + first.query_ms),
                              "copies", r.update_ms / copy, "refitted_percent", 100 * r.refitted, "bytes_per_triangle",
                              r.bytes, "pairs", pairs, "differ", others));
        }
    }
    table.commit();
    return code_of(wrong);
}

} // namespace

void add_deform_bench(Arguments bench)
{
    Benchmark<DeformOptions> b(bench, "deform", "Meshes whose vertices move in every frame", bench_deform);
    b.whole("--triangles N", b->triangles, "approximate triangles of a cloth", {1000, 100'000'000});
    b.whole("--frames N", b->frames, "frames that are timed", {1, 10'000});
    b.repeats(), b.only(), b.csv("scene and contender");
    b.footer("'a small body': a cloth waves, and touches a ball with about 1 % of its triangles. 'two cloths': both "
             "wave and pass through each other in many places. 'ratio': to the time of the first contender. 'copies': "
             "the update, as a multiple of a copy of the vertices. 'refitted': boxes of the first cloth's tree fitted "
             "anew in a frame. 'differ': pairs of triangles that the first contender does not find, or the other way "
             "round. Exit code 70: such a pair of a contender with exact tests, oncollide or Embree.");
}

} // namespace oncollide::tools
