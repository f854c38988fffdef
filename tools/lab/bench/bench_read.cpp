// oncollide-lab bench read: speed of reading files of meshes and scenes.
#include "bench/common/benchmark.hpp"
#include "bench/mesh_files.hpp"
#include "cli/log.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

#include "cli/system.hpp"

namespace oncollide::tools {
namespace {

struct ReadOptions : SharedOptions {
    std::vector<std::string> files; ///< empty: generated files
    std::string styles;             ///< styles of the generated files; empty: all
    int triangles = 10'000'000;
    std::string folder; ///< for generated files; empty: the system's temporary folder
};

namespace fs = std::filesystem;

struct ReadRow {
    std::size_t count = 0; ///< triangles, or bodies
    std::uintmax_t bytes = 0;
    double ms = 0, wall_ms = 0; ///< processor time of the thread, and elapsed time
    std::size_t peak = 0;       ///< largest growth of the process, bytes
};

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
    explicit ReadBench(const ReadOptions& options) : options_(options), table_(options.csv) {}

    int run()
    {
        const std::string files = options_.files.empty() ? fmt::format("height fields of {} triangles, seed {}",
                                                                       grouped(2 * cells() * cells()), options_.seed)
                                                         : fmt::format("{} given", options_.files.size());
        say("{}files      {}; least time of {} runs, on one thread\n\n", describe_program("reading"), files,
            options_.repeats);
        for (const std::string& file : options_.files)
            if (!interrupted()) report(file, read_repeatedly(file, options_.repeats), "");
        if (options_.files.empty()) run_styles();
        table_.commit();
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
            const ScratchFolder folder(options_.folder);
            const fs::path file = folder.path() / fmt::format("mesh.{}", style.extension);
            write_mesh_file(style, file, cells(), options_.seed);
            if (interrupted()) return;
            const ReadRow row = read_repeatedly(file, options_.repeats);
            if (row.count != 2u * cells() * cells())
                throw Error(ErrorKind::internal, fmt::format("bench read: {}: read {} triangles of {}", style.name,
                                                             row.count, 2 * cells() * cells()));
            report(std::string(style.name), row, style.what);
        }
    }
    void report(const std::string& name, const ReadRow& row, std::string_view what)
    {
        const double seconds = row.ms / 1e3;
        table_.row(figures("style", name, "bytes", row.bytes, "triangles", row.count, "ms", row.ms, "wall_ms",
                           row.wall_ms, "triangles_per_s", std::uint64_t(double(row.count) / seconds), "mb_per_s",
                           1e-6 * double(row.bytes) / seconds, "peak_bytes", row.peak, "bytes_each",
                           double(row.peak) / double(row.count), "what", what));
    }

    const ReadOptions& options_;
    ResultTable table_;
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
    check_styles(options.styles);
    catch_interrupts();
    return ReadBench(options).run();
}

} // namespace

void add_read(Arguments bench)
{
    Benchmark<ReadOptions> b(bench, "read", "Reading mesh files: triangles per second and memory, by format",
                             bench_read);
    b.input("files FILE...", b->files,
            "mesh files, or scene files, whose bodies are counted (default: a generated height field in each style)")
        .expected(0, 1000);
    b.option("--styles LIST", b->styles,
             "styles of the generated files: obj, obj-full, obj-back, obj-exact, stl, stl-mixed, ply, stl-text, "
             "ply-text, off (default: all)");
    b.whole("--triangles N", b->triangles, "approximate triangles of the height field", {2, 100'000'000});
    b.repeats("number of runs; each file's least time counts"), b.seed("the heights");
    b.option("--folder DIR", b->folder, "folder for the generated files (default: $TMPDIR)");
    b.csv("file");
    b.footer("'ms' is processor time of the thread, 'wall, ms' elapsed time: reading from the system's cache, checks, "
             "welding (STL).\n"
             "'peak bytes' is the largest growth of the process, 'bytes each' the same per triangle.");
}

} // namespace oncollide::tools
