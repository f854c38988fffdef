// oncollide-lab bench clash: time from files to a complete report, and a check of the report.
#include "bench/bench.hpp"
#include "clash/clash_pictures.hpp"
#include "clash/report.hpp"
#include "common/text.hpp"
#include "planted/planted_assembly.hpp"

#include <chrono>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

#include "cli/options.hpp"
#include "cli/system.hpp"

namespace oncollide::tools {
namespace {

struct ClashBenchOptions {
    int parts = 5000, triangles = 1000, every = 10, repeats = 1, threads = 2, pictures = 40;
    bool real = false;
    std::string data, write, csv;
};

namespace fs = std::filesystem;

/// A folder that is removed after the benchmark, unless it was named.
class Folder {
public:
    explicit Folder(const std::string& named) : path_(named), keep_(!named.empty())
    {
        if (!keep_) {
            std::string pattern = (temporary_files() / "oncollide-clash-XXXXXX").string();
            if (!::mkdtemp(pattern.data())) throw Error(ErrorKind::cannot_write, pattern + ": cannot create");
            path_ = pattern;
        }
        std::error_code error;
        fs::create_directories(path_ / "parts", error);
        if (error) throw Error(ErrorKind::cannot_write, fmt::format("{}: {}", path_.string(), error.message()));
    }
    ~Folder()
    {
        std::error_code ignored;
        if (!keep_) fs::remove_all(path_, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    const fs::path& path() const { return path_; }

private:
    fs::path path_;
    bool keep_;
};

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

class LapTimer {
public:
    double lap()
    {
        const auto now = std::chrono::steady_clock::now();
        const double s = std::chrono::duration<double>(now - std::exchange(last_, now)).count();
        return s;
    }

private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

struct Times {
    double read, find, report, page;
    double all() const { return read + find + report; }
};

/// Reads, finds and writes; adds faults of the result to `faults`.
Times run(const std::vector<std::string>& files, const PlantedAssembly& planted, const ClashBenchOptions& o,
          const fs::path& folder, std::vector<std::string>& faults)
{
    const Units units({"mm"});
    const int threads = o.threads ? o.threads : hardware_threads();
    PainterProcess painter;
    const ClashSettings settings{.clearance = PlantedOptions{}.clearance, .threads = threads};
    Times times{};
    LapTimer timer;
    const PartList parts = read_parts(files, units, {}, threads);
    times.read = timer.lap();
    const Clashes found = find_clashes(parts, settings);
    times.find = timer.lap();
    const ClashReport report{parts, found, units.reported(), settings, "", "", {}, parts.warnings};
    OutputFile json(folder / "report.json");
    write_json(json, report), json.commit();
    times.report = timer.lap();
    OutputFile page(folder / "report.html");
    write_page(page, report, draw_clashes(report, painter, std::size_t(o.pictures), true)), page.commit();
    times.page = timer.lap();
    faults = faults_of(planted, parts, found.list);
    return times;
}

/// Clash reports of an assembly with known clashes, from files to report. Returns the exit code: 70 if a clash was
/// missed, invented or measured wrongly.
int bench_clash(const ClashBenchOptions& o)
{
    check_range("--parts", o.parts, 2, 1'000'000), check_range("--triangles", o.triangles, 100, 10'000'000);
    check_range("--repeats", o.repeats, 1), check_range("--every", o.every, 1),
        check_range("--threads", o.threads, 0, 1024);
    const Folder folder(o.write);
    const PlantedAssembly planted =
        make_planted_assembly({.parts = std::size_t(o.parts),
                               .triangles = o.triangles,
                               .meshes = o.real ? meshes_of(data_folder(o.data)) : std::vector<Mesh>(),
                               .every = std::size_t(o.every)});
    write_stl_files(planted, folder.path() / "parts");
    write_glb_file(planted, folder.path() / "assembly.glb");
    say("{}", describe_program("cpu"));
    say("{} parts, {} triangles, {} planted pairs (touching, crossing, enclosed, duplicate, near); seconds, {} "
        "threads\n",
        grouped(planted.parts.size()), grouped(planted.triangles), grouped(planted.pairs.size()),
        o.threads ? o.threads : hardware_threads());
    CsvFile csv(o.csv,
                "meshes,files,parts,triangles,planted,threads,read_s,find_s,json_s,all_s,page_s,pictures,faults");
    say("{:<14} {:>8} {:>8} {:>8} {:>8} {:>10} {:>8}\n", "files", "read", "find", "JSON", "all", "page", "faults");
    bool faulty = false;
    for (const auto& [name, files] : {std::pair("STL files", files_of({(folder.path() / "parts").string()})),
                                      std::pair("one GLB", std::vector{(folder.path() / "assembly.glb").string()})}) {
        Times best{.read = 1e9, .find = 0, .report = 0, .page = 0};
        std::vector<std::string> faults;
        for (int k = 0; k < o.repeats; ++k) {
            const Times times = run(files, planted, o, folder.path(), faults);
            if (times.all() < best.all()) best = times;
        }
        faulty |= !faults.empty();
        say("{:<14} {:>8.2f} {:>8.2f} {:>8.2f} {:>8.2f} {:>10.2f} {:>8}\n", name, best.read, best.find, best.report,
            best.all(), best.page, faults.size());
        for (std::size_t k = 0; k < std::min<std::size_t>(faults.size(), 20); ++k) say("FAULT: {}\n", faults[k]);
        csv.row(o.real ? "real" : "made", name, planted.parts.size(), planted.triangles, planted.pairs.size(),
                o.threads ? o.threads : hardware_threads(), Fixed{best.read, 3}, Fixed{best.find, 3},
                Fixed{best.report, 3}, Fixed{best.all(), 3}, Fixed{best.page, 3}, o.pictures, faults.size());
    }
    csv.commit();
    return faulty ? int(ErrorKind::internal) : 0;
}

} // namespace

void add_clash_bench(Arguments bench)
{
    Arguments sub = bench.add_command("clash", "Clash reports of an assembly with known clashes, from files to report");
    auto options = std::make_shared<ClashBenchOptions>();
    sub.add_option("--parts N", options->parts, "number of parts of the assembly (default 5000)");
    sub.add_option("--triangles N", options->triangles, "triangles per part (default 1000)");
    sub.add_flag("--real", options->real, "use the data folder's meshes of up to 20,000 triangles");
    sub.add_option("--every N", options->every, "every N-th site has a planted pair (default 10)");
    sub.add_option("--threads N", options->threads, "number of threads; 0: all (default 2)");
    sub.add_option("--repeats N", options->repeats, "number of runs; the fastest counts (default 1)");
    sub.add_option("--pictures N", options->pictures, "number of clashes to draw in the page (default 40)");
    sub.add_option("--data DIR", options->data, "folder with meshes/ (default: $ONCOLLIDE_DATA, else ../shared/data)");
    sub.add_option("--write FOLDER", options->write, "keep the assembly and its reports in this folder");
    sub.add_option("--csv FILE", options->csv, "write one row per kind of file");
    sub.footer("Planted pairs cross deeply or barely, touch, are near or slightly too far, are enclosed, or lie free "
               "in\n"
               "a hollow or a ring. Exit code 70: a clash was missed, invented or measured\n"
               "wrongly.");
    sub.action([options] { return bench_clash(*options); });
}

} // namespace oncollide::tools
