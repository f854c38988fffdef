// oncollide-lab bench read: speed of reading files of meshes and scenes.
#include "bench/bench.hpp"
#include "bench/mesh_files.hpp"
#include "cli/log.hpp"
#include "cli/options.hpp"
#include "common/text.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <memory>
#include <random>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

#include "cli/system.hpp"

namespace oncollide::tools {
namespace {

struct ReadOptions {
    std::vector<std::string> files; ///< empty: generated files
    std::string styles;             ///< styles of the generated files; empty: all
    int triangles = 10'000'000;
    int repeats = 3;
    std::uint64_t seed = 12345;
    std::string folder; ///< for generated files; empty: the system's temporary folder
    std::string csv;
};

namespace fs = std::filesystem;

/// A file that is removed at the end of its scope.
class PassingFile {
public:
    PassingFile(const fs::path& folder, std::string_view extension)
        : path_(folder / fmt::format("oncollide-read-{:08x}.{}", std::random_device()(), extension))
    {
    }
    ~PassingFile()
    {
        std::error_code ignored;
        fs::remove(path_, ignored);
    }
    PassingFile(const PassingFile&) = delete;
    const fs::path& path() const { return path_; }

private:
    fs::path path_;
};

struct ReadRow {
    std::size_t count = 0; ///< triangles, or bodies
    std::uintmax_t bytes = 0;
    double ms = 0, wall_ms = 0; ///< processor time of the thread, and elapsed time
    std::size_t peak = 0;       ///< largest growth of the process, bytes
};

/// Processor time of this thread, because other work on the machine affects it less.
double processor_ms()
{
    std::timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * double(t.tv_sec) + 1e-6 * double(t.tv_nsec);
}

/// Number of triangles of a mesh, or of bodies of a scene.
std::size_t read_count(const fs::path& path)
{
    if (path.extension() != ".json") return load_mesh(path).triangles.size();
    return load_scene(path, {.generators = &sample_generators()}).size();
}

/// The least time of `repeats` readings; all except the first come from the system's file cache.
ReadRow read_repeatedly(const fs::path& path, int repeats)
{
    ReadRow row;
    for (int i = 0; i == 0 || (i < repeats && !interrupted()); ++i) {
        trim_memory();
        const std::size_t before = resident_memory();
        forget_peak_memory();
        const auto start = Clock::now();
        const double from = processor_ms();
        row.count = read_count(path);
        const double ms = processor_ms() - from, wall_ms = milliseconds_since(start);
        row.ms = i == 0 ? ms : std::min(row.ms, ms);
        row.wall_ms = i == 0 ? wall_ms : std::min(row.wall_ms, wall_ms);
        row.peak = std::max(row.peak, peak_memory() - std::min(before, peak_memory()));
    }
    row.bytes = bytes_of_file(path);
    return row;
}

class ReadBench {
public:
    explicit ReadBench(const ReadOptions& options)
        : options_(options), csv_(options.csv, "style,bytes,triangles,ms,wall_ms,triangles_per_s,mb_per_s,peak_bytes")
    {
    }

    int run()
    {
        const std::string files = options_.files.empty() ? fmt::format("height fields of {} triangles, seed {}",
                                                                       grouped(2 * cells() * cells()), options_.seed)
                                                         : fmt::format("{} given", options_.files.size());
        say("{}files      {}; least time of {} runs, on one thread\n\n", describe_program("reading"), files,
            options_.repeats);
        say("{:<12}{:>10}{:>14}{:>10}{:>10}{:>16}{:>9}{:>10}{:>12}\n", "", "MB", "triangles", "ms", "wall ms",
            "per second", "MB / s", "peak MB", "bytes each");
        for (const std::string& file : options_.files)
            if (!interrupted()) report(file, read_repeatedly(file, options_.repeats), "");
        if (options_.files.empty()) run_styles();
        csv_.commit();
        if (!interrupted()) return 0;
        log(LogLevel::error, "interrupted; the rows so far were written");
        return interrupted_code;
    }

private:
    std::uint32_t cells() const { return static_cast<std::uint32_t>(std::lround(std::sqrt(0.5 * options_.triangles))); }
    void run_styles()
    {
        for (const MeshFileStyle& style : mesh_file_styles) {
            if (interrupted()) return;
            const std::vector<std::string> wanted = split(options_.styles);
            if (!options_.styles.empty() && std::ranges::find(wanted, style.name) == wanted.end()) continue;
            const PassingFile file(options_.folder.empty() ? temporary_files() : fs::path(options_.folder),
                                   style.extension);
            write_mesh_file(style, file.path(), cells(), options_.seed);
            if (interrupted()) return;
            const ReadRow row = read_repeatedly(file.path(), options_.repeats);
            if (row.count != 2u * cells() * cells())
                throw Error(ErrorKind::internal, fmt::format("bench read: {}: read {} triangles of {}", style.name,
                                                             row.count, 2 * cells() * cells()));
            report(std::string(style.name), row, style.what);
        }
    }
    void report(const std::string& name, const ReadRow& row, std::string_view what)
    {
        const double seconds = row.ms / 1e3, megabytes = double(row.bytes) / 1e6;
        say("{:<12}{:>10.1f}{:>14}{:>10.1f}{:>10.1f}{:>16}{:>9.0f}{:>10.0f}{:>12.0f}   {}\n", printable(name),
            megabytes, grouped(row.count), row.ms, row.wall_ms, grouped(std::uint64_t(double(row.count) / seconds)),
            megabytes / seconds, double(row.peak) / 1e6, double(row.peak) / double(row.count), what);
        csv_.row(name, row.bytes, row.count, Fixed{row.ms, 3}, Fixed{row.wall_ms, 3},
                 Fixed{double(row.count) / seconds, 0}, Fixed{megabytes / seconds, 1}, row.peak);
    }

    const ReadOptions& options_;
    CsvFile csv_;
};

void check_styles(const std::string& list)
{
    if (list.empty()) return;
    for (const std::string& name : split(list)) {
        if (std::ranges::find(mesh_file_styles, name, &MeshFileStyle::name) != mesh_file_styles.end()) continue;
        std::vector<std::string_view> known;
        for (const MeshFileStyle& style : mesh_file_styles) known.push_back(style.name);
        usage(fmt::format("--styles: unknown style '{}'{}", name, valid_names(name, known, "valid")));
    }
}

/// Reads mesh files of every format. Returns the exit code.
int bench_read(const ReadOptions& options)
{
    check_range("--triangles", options.triangles, 2, 100'000'000);
    check_range("--repeats", options.repeats, 1, 1000);
    check_styles(options.styles);
    check_files({{"--csv", options.csv}}, options.files);
    catch_interrupts();
    return ReadBench(options).run();
}

} // namespace

void add_read(Arguments bench)
{
    Arguments sub = bench.add_command("read", "Reading mesh files: triangles per second and memory, by format");
    auto options = std::make_shared<ReadOptions>();
    sub.add_option(
           "files FILE...", options->files,
           "mesh files, or scene files, whose bodies are counted (default: a generated height field in each style)")
        .expected(0, 1000);
    sub.add_option("--styles LIST", options->styles,
                   "styles of the generated files: obj, obj-full, obj-back, obj-exact, stl, stl-mixed, ply, stl-text, "
                   "ply-text, off (default: all)");
    sub.add_option("--triangles N", options->triangles, "approximate triangles of the height field (default 10000000)");
    sub.add_option("--repeats N", options->repeats, "number of runs; each file's least time counts (default 3)");
    sub.add_option("--seed S", options->seed, "seed of the heights (default 12345)");
    sub.add_option("--folder DIR", options->folder, "folder for the generated files (default: $TMPDIR)");
    sub.add_option("--csv FILE", options->csv, "write one row per file");
    sub.footer("'ms' is processor time of the thread, 'wall ms' elapsed time: reading from the system's cache, checks, "
               "welding (STL).\n"
               "'peak MB' is the largest growth of the process, 'bytes each' the same per triangle.");
    sub.action([options] { return bench_read(*options); });
}

} // namespace oncollide::tools
