// oncollide-lab bench broad: time to find all overlapping boxes, compared with the broad phases of other libraries.
#include "bench/broad/aabbs_file.hpp"
#include "bench/broad/broad_race.hpp"
#include "bench/common/benchmark.hpp"
#include "common/line_plot.hpp"

#include <algorithm>
#include <map>

namespace oncollide::tools {
namespace {

struct BroadOptions : SharedOptions {
    std::string scene = "brown", sizes = "1k,10k,100k", thread_counts = "1";
    bool sizes_given = false;
    bool per_box = false; ///< the plot shows nanoseconds per box
    std::optional<int> frames;
};

bool is_recording(const std::string& scene)
{
    return scene.ends_with(".aabbs") || scene.find('/') != std::string::npos;
}

/// The frame number of the published results.
std::uint64_t usual_frames(std::size_t boxes)
{
    return boxes <= 3'000 ? 60 : boxes <= 30'000 ? 40 : boxes <= 300'000 ? 12 : 8;
}

std::string delimitation_text(const RaceRow& row)
{
    if (row.levels.empty()) return "delimitation off: more than a quarter of the boxes changed";
    std::string text = "delimitation by level, rejected:";
    for (const DelimitationLevel& level : std::span(row.levels).subspan(1))
        text += fmt::format(" {} of {} regions with {} boxes, {:.0f} % of the volume ruled out, {:.4f} ms;",
                            level.regions_rejected, level.regions, level.bodies_rejected, 100 * level.volume_rejected,
                            level.ms);
    return text += fmt::format(" {} boxes left", row.left);
}

double delimitation_ms(const RaceRow& row)
{
    double ms = 0;
    for (const DelimitationLevel& level : row.levels) ms += level.ms;
    return ms;
}

PlotAxes axes(bool per_box)
{
    if (per_box) return {"boxes", "ns per box and frame", [](double ns) { return plain_measure(ns, 3) + " ns"; }};
    return {"boxes", "ms per frame",
            [](double ms) { return ms >= 1000 ? plain_measure(ms / 1e3, 3) + " s" : plain_measure(ms, 3) + " ms"; }};
}

class BroadBench {
public:
    explicit BroadBench(const BroadOptions& options)
        : options_(options), contenders_(all_contenders().broad), shard_(shard_from(options.shard)),
          table_(options.csv, {18},
                 shard_.line(fmt::format("bench broad, {}, sizes {}, {} frames, seed {}, threads {}, only {}",
                                         options.scene, options.sizes, options.frames.value_or(0), options.seed,
                                         options.thread_counts, options.only)))
    {
        for (const std::size_t threads : parse_counts("--threads", options.thread_counts, 256))
            threads_.push_back(int(threads));
        contenders_.keep(options.only);
        choose_scenes();
    }

    int run()
    {
        say("{}", describe_program("broad phase alone"));
        print_missing(contenders_.missing);
        std::string last;
        for (const auto& [scene, size] : work_) {
            if (scene != last) panels_.push_back({scene, {}});
            last = scene;
            run(is_recording(scene) ? open_aabbs(scene) : make_box_scene(scene, size, options_.seed));
        }
        table_.commit();
        if (!options_.plot.empty()) {
            OutputFile file(options_.plot);
            draw_line_plot(file, panels_, axes(options_.per_box)), file.commit();
        }
        return code_of(wrong_);
    }

private:
    /// Finds all faults of scenes before any work.
    void choose_scenes()
    {
        const std::vector<std::size_t> sizes = parse_counts("--sizes", options_.sizes, most_boxes);
        if (is_recording(options_.scene))
            work_.emplace_back(options_.scene, 0);
        else
            for (const std::string& scene : split(options_.scene)) {
                make_box_scene(scene, 1, options_.seed);
                for (const std::size_t size : sizes) work_.emplace_back(scene, size);
            }
        keep_part(shard_, work_, "scenes and sizes");
        if (!is_recording(options_.scene)) return;
        if (options_.sizes_given) usage(fmt::format("--sizes: does not apply to the recording {}", options_.scene));
        const std::uint64_t last = open_aabbs(options_.scene).last_frame;
        if (last < 2 || std::uint64_t(options_.frames.value_or(2)) > last)
            usage(fmt::format("{}: has {} frames after the initial one; {} are requested", options_.scene, last,
                              options_.frames.value_or(2)));
    }

    void run(BoxScene scene)
    {
        const std::uint64_t usual = usual_frames(scene.boxes.size());
        const std::uint64_t frames = std::min(scene.last_frame, std::uint64_t(options_.frames.value_or(int(usual))));
        const auto statics = std::size_t(std::count(scene.is_static.begin(), scene.is_static.end(), 1));
        table_.section(fmt::format("{}, {} boxes ({} static), seed {}: frames {} to {}", printable(scene.name),
                                   grouped(scene.boxes.size()), grouped(statics), options_.seed,
                                   std::max<std::uint64_t>(2, frames / 3 + 1), frames));
        flush_stdout();
        const RaceResult result = race(scene, contenders_.all, threads_, frames, frames / 3);
        for (const RaceRow& row : result.rows) {
            wrong_ |= row.missed > 0;
            record(scene, row);
        }
        print_result(scene, result);
    }

    void print_result(const BoxScene& scene, const RaceResult& result)
    {
        for (const RaceRow& row : result.rows)
            if (row.delimited && row.threads == threads_.front())
                say("  {:<18}{}\n", row.contender->name, delimitation_text(row));
        for (const std::string& reason : result.left) say("  left out  {}\n", reason);
        say("  result    {} pairs, hash {:016x}", grouped(result.pairs.count), result.pairs.hash);
        if (const auto published = published_result(scene.name, scene.boxes.size(), scene.frame);
            published && options_.seed == 12345) {
            const bool match = *published == result.pairs;
            say(": {} the published result", match ? "matches" : "MISMATCH with");
            wrong_ |= !match;
        }
        say("\n");
        flush_stdout();
    }

    void record(const BoxScene& scene, const RaceRow& row)
    {
        table_.about(figures("scene", scene.name, "boxes", scene.boxes.size(), "movers", scene.moved.size(), "frame",
                             scene.frame, "seed", options_.seed));
        table_.row(figures("contender", row.contender->name, "threads", row.threads, "ms", row.ms, "ratio", row.ratio,
                           "bytes", std::uint64_t(row.bytes), "pairs", row.pairs.count, "missed", row.missed, "extra",
                           row.extra, "library", row.contender->what),
                   figures("hash", Hex{row.pairs.hash}, "regions", regions_text(row.levels), "left", row.left,
                           "delimitation_ms", delimitation_ms(row)));
        const std::string label =
            row.threads == 1 ? row.contender->name : fmt::format("{}, {} threads", row.contender->name, row.threads);
        const auto style = styles_.try_emplace(label, styles_.size()).first;
        std::vector<PlotLine>& lines = panels_.back().lines;
        auto line = std::find_if(lines.begin(), lines.end(), [&](const PlotLine& l) { return l.label == label; });
        if (line == lines.end()) {
            using Weight = PlotLine::Weight;
            constexpr Weight weights[] = {Weight::main, Weight::baseline, Weight::peer}; // by group
            lines.push_back({weights[int(row.contender->group)], label, {}, style->second});
            line = std::prev(lines.end());
        }
        const double boxes = double(scene.boxes.size()), ms = std::max(row.ms, 1e-4);
        line->points.push_back({boxes, options_.per_box ? 1e6 * ms / boxes : ms});
    }

    BroadOptions options_;
    BroadContenders contenders_;
    std::vector<int> threads_;
    Shard shard_;
    std::vector<std::pair<std::string, std::size_t>> work_; ///< every combination of scene and size
    ResultTable table_;
    std::vector<PlotPanel> panels_;             ///< one per scene
    std::map<std::string, std::size_t> styles_; ///< of the lines, by label
    bool wrong_ = false;
};

/// Compares only the broad phase, on boxes, with other libraries. Returns the exit code: 70 if oncollide missed a pair
/// or a scene did not give its published pairs.
int bench_broad(const BroadOptions& options)
{
    return BroadBench(options).run();
}

} // namespace

void add_broad(Arguments bench)
{
    Benchmark<BroadOptions> b(bench, "broad", "Only the broad phase, on boxes, compared with other libraries",
                              bench_broad);
    b.option("--scene LIST|FILE.aabbs", b->scene,
             "scenes, or a recording: brown (default), large, mixed, flat, clustered, static, giant, jump, and "
             "freefall, brownian, gravity with -cubes or -assorted");
    Option sizes = b.option("--sizes LIST", b->sizes, "numbers of boxes, such as 2500,10k,1M (default 1k,10k,100k)");
    b.whole("--frames N", b->frames, "frames to play; the first third is not timed (default 60 to 8)", {2, 100'000});
    b.option("--threads LIST", b->thread_counts, "numbers of threads (default 1)");
    b.only(), b.csv("contender and size"), b.shard("scenes and sizes");
    Option plot = b.plot("time against size, one panel per scene");
    b.flag("--per-box", b->per_box, "plot nanoseconds per box, to show growth").needs(plot);
    b.seed("the scene");
    b.prepare([sizes](BroadOptions& o) { o.sizes_given = sizes.given(); });
}

} // namespace oncollide::tools
