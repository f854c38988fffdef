// oncollide-lab bench clash: time from files to a complete report, and a check of the report.
#include "bench/common/benchmark.hpp"
#include "clash/clash_pictures.hpp"
#include "clash/parts/file_list.hpp"
#include "clash/report.hpp"
#include "planted/planted_assembly.hpp"

#include <filesystem>

#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

#include "cli/system.hpp"

namespace oncollide::tools {
namespace {

struct ClashBenchOptions : SharedOptions {
    int parts = 5000, triangles = 1000, every = 10, pictures = 40;
    bool real = false;
    std::string write;
};

namespace fs = std::filesystem;

/// The small meshes of the data folder: parts have a thousand triangles, not a million.
std::vector<Mesh> meshes_of(const fs::path& data)
{
    constexpr std::size_t most = 20'000;
    std::vector<Mesh> meshes;
    if (data.empty()) return meshes;
    for (const std::string& file : files_of({(data / "meshes").string()})) {
        Mesh mesh = load_mesh(file);
        if (mesh.triangles.size() <= most) meshes.push_back(std::move(mesh));
    }
    return meshes;
}

struct Times {
    double read, find, report, page;
    double all() const { return read + find + report; }
};

/// Reads, finds and writes; adds faults of the result to `faults`.
Times run(const std::vector<std::string>& files, const PlantedAssembly& planted, const ClashBenchOptions& o,
          const fs::path& folder, std::vector<std::string>& faults)
{
    const Units units({"mm"});
    const int threads = threads_of(o.threads);
    PainterProcess painter;
    ClashSettings settings{
        .clearance = PlantedOptions{}.clearance, .tolerance = tolerance_of_files, .threads = threads};
    Times times{};
    Clock::time_point last = Clock::now();
    const auto lap = [&] { return 1e-3 * milliseconds_since(std::exchange(last, Clock::now())); };
    PartList parts = read_parts(files, units, {}, threads);
    times.read = lap();
    mend(parts, settings);
    const Clashes found = find_clashes(parts, settings);
    times.find = lap();
    const ClashReport report{parts, found, units.reported(), settings, "", "", {}, parts.warnings};
    OutputFile json(folder / "report.json");
    write_json(json, report), json.commit();
    times.report = lap();
    OutputFile page(folder / "report.html");
    write_page(page, report, draw_clashes(report, painter, std::size_t(o.pictures), true)), page.commit();
    times.page = lap();
    faults = faults_of(planted, parts, found.list);
    return times;
}

/// Clash reports of an assembly with known clashes, from files to report. Returns the exit code: 70 if a clash was
/// missed, invented or measured wrongly.
int bench_clash(const ClashBenchOptions& o)
{
    std::optional<ScratchFolder> scratch;
    const fs::path folder = o.write.empty() ? scratch.emplace().path() : fs::path(o.write);
    std::error_code error;
    fs::create_directories(folder / "parts", error);
    if (error) throw Error(ErrorKind::cannot_write, fmt::format("{}: {}", folder.string(), error.message()));
    const PlantedAssembly planted =
        make_planted_assembly({.parts = std::size_t(o.parts),
                               .triangles = o.triangles,
                               .meshes = o.real ? meshes_of(data_folder(o.data)) : std::vector<Mesh>(),
                               .every = std::size_t(o.every)});
    write_stl_files(planted, folder / "parts");
    write_glb_file(planted, folder / "assembly.glb");
    say("{}", describe_program("cpu"));
    say("{} parts, {} triangles, {} planted pairs (touching, crossing, enclosed, duplicate, near); seconds, {} "
        "threads\n",
        grouped(planted.parts.size()), grouped(planted.triangles), grouped(planted.pairs.size()),
        threads_of(o.threads));
    ResultTable table(o.csv, {14});
    table.about(figures("meshes", o.real ? "real" : "made", "parts", planted.parts.size(), "triangles",
                        planted.triangles, "planted", planted.pairs.size(), "threads", threads_of(o.threads),
                        "pictures", o.pictures));
    bool faulty = false;
    for (const auto& [name, files] : {std::pair("STL files", files_of({(folder / "parts").string()})),
                                      std::pair("one GLB", std::vector{(folder / "assembly.glb").string()})}) {
        Times best{.read = 1e9, .find = 0, .report = 0, .page = 0};
        std::vector<std::string> faults;
        for (int k = 0; k < o.repeats; ++k) {
            const Times times = run(files, planted, o, folder, faults);
            if (times.all() < best.all()) best = times;
        }
        faulty |= !faults.empty();
        table.row(figures("files", name, "read_s", best.read, "find_s", best.find, "json_s", best.report, "all_s",
                          best.all(), "page_s", best.page, "faults", faults.size()));
        for (std::size_t k = 0; k < std::min<std::size_t>(faults.size(), 20); ++k) say("FAULT: {}\n", faults[k]);
    }
    table.commit();
    return code_of(faulty);
}

} // namespace

void add_clash_bench(Arguments bench)
{
    Benchmark<ClashBenchOptions> b(
        bench, "clash", "Clash reports of an assembly with known clashes, from files to report", bench_clash);
    b->repeats = 1, b->threads = 2;
    b.whole("--parts N", b->parts, "number of parts of the assembly", {2, 1'000'000});
    b.whole("--triangles N", b->triangles, "triangles per part", {100, 10'000'000});
    b.flag("--real", b->real, "use the data folder's meshes of up to 20,000 triangles");
    b.whole("--every N", b->every, "every N-th site has a planted pair");
    b.threads("number of threads"), b.repeats();
    b.whole("--pictures N", b->pictures, "number of clashes to draw in the page", {0});
    b.data();
    b.option("--write FOLDER", b->write, "keep the assembly and its reports in this folder");
    b.csv("kind of file");
    b.footer("Planted pairs cross deeply or barely, touch, are near or slightly too far, are enclosed, or lie free in\n"
             "a hollow or a ring. Exit code 70: a clash was missed, invented or measured wrongly.");
}

} // namespace oncollide::tools
