// oncollide-lab bench octants: speed and errors of each backend in finding the octants that a surface intersects.
#include "bench/bench.hpp"
#include "bench/paper/octant_candidate.hpp"
#include "cli/options.hpp"
#include "cli/standard_output.hpp"
#include "common/text.hpp"

#include <algorithm>
#include <bit>
#include <memory>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/narrowphase/gl/gpu.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::tools {
namespace {

struct OctantsOptions {
    std::string data, only, csv;
    int gpu = -1, repeats = 5;
    double limit_s = 2; ///< batches that would take longer are skipped
};

class OctantBench {
public:
    explicit OctantBench(const OctantsOptions& options)
        : options_(options), data_(data_folder(options.data)), contenders_(octant_contenders(options.gpu)),
          csv_(options.csv, "part,mesh,triangles,backend,n,value,other")
    {
    }

    void run()
    {
        const GpuInfo gpu = describe_gpu(options_.gpu);
        say("{}GPU        {}, OpenGL {}; context in {:.0f} ms\n\n", describe_program(make_cpu_backend()->name()),
            gpu.renderer, gpu.version, gpu.start_ms);
        const std::vector<NamedMesh> meshes{
            mesh_or_knot(data_, "paper/lamp.obj", 600), mesh_or_knot(data_, "paper/bunny.obj", 1500),
            mesh_or_knot(data_, "paper/cow_5144.obj", 5144), mesh_or_knot(data_, "bunny_69k.obj", 69451)};
        if (wanted("speed"))
            for (const NamedMesh& mesh : meshes) speed(mesh);
        if (wanted("trees")) {
            trees(meshes[2], {5, 6, 7});
            trees(meshes[3], {5, 6, 7});
        }
        if (wanted("misses")) {
            for (int i : {0, 1, 2}) misses(meshes[std::size_t(i)], 6);
            misses({"needles", make_needles_mesh(300, 1, 1e4, 3, 7)}, 6);
            misses({"tiny triangles", make_soup_mesh(400, 1e-4, 3, 9)}, 6);
        }
        csv_.commit();
    }

private:
    bool wanted(const std::string& part) const { return options_.only.empty() || options_.only == part; }

    void record(const char* part, const NamedMesh& mesh, const std::string& backend, std::size_t n, double value,
                double other)
    {
        csv_.row(part, mesh.name, mesh.mesh.triangles.size(), Quoted{backend}, n, value, other);
    }

    /// Octants per second, by size of the batch.
    void speed(const NamedMesh& mesh)
    {
        const std::size_t batches[] = {24, 240, 2400, 24000};
        const OctantLevels levels(mesh.mesh, 8);
        say("million octants per second: {}, {} triangles\n{:<34}", mesh.name, grouped(mesh.mesh.triangles.size()),
            "  rows per batch");
        for (std::size_t rows : batches) say("{:>12}", grouped(rows));
        say("\n");
        for (const OctantContender& contender : contenders_) {
            say("  {:<32}", contender.name);
            Candidate candidate(contender, levels);
            double row_ms = 0;
            for (std::size_t rows : batches) {
                if (row_ms * double(rows) > options_.limit_s * 1e3) {
                    say("{:>12}", "-"); // predicted from the batch before
                    continue;
                }
                const double ms = candidate.measure(rows, row_ms * double(rows) > 200 ? 1 : options_.repeats).ms;
                row_ms = ms / double(rows);
                say("{:>12.4f}", 8e-3 * double(rows) / ms);
                flush_stdout();
                record("speed", mesh, contender.name, rows, 8e3 * double(rows) / ms, ms);
            }
            say("\n");
        }
        say("\n");
    }

    /// The whole tree, one batch per level.
    void trees(const NamedMesh& mesh, std::initializer_list<int> depths)
    {
        say("whole tree, ms (GPU's clock): {}, {} triangles\n{:<34}", mesh.name, grouped(mesh.mesh.triangles.size()),
            "  depth");
        for (int depth : depths) say("{:>20}", depth);
        say("\n");
        const OctantLevels levels(mesh.mesh, 7);
        for (const OctantContender& contender : contenders_) {
            if (contender.name.starts_with("gl-query"))
                continue; // would take minutes; its speed is in the table before
            say("  {:<32}", contender.name);
            Candidate candidate(contender, levels);
            for (int depth : depths) {
                const auto [best, gpu] = candidate.measure_tree(depth, options_.repeats);
                say("{:>20}", gpu > 0 ? fmt::format("{:.3f} ({:.3f})", best, gpu) : fmt::format("{:.3f}", best));
                record("tree", mesh, contender.name, std::size_t(depth), best, gpu);
            }
            say("\n");
        }
        say("\n");
    }

    /// Missed and extra octants, over all true cells above `depth`.
    void misses(const NamedMesh& mesh, int depth)
    {
        const OctantLevels levels(mesh.mesh, depth);
        std::uint64_t grey = 0;
        for (int level = 0; level < depth; ++level)
            for (const auto& cell : levels.level(level)) grey += std::uint64_t(std::popcount(cell.truth));
        say("missed and extra octants to depth {}: {}, {} triangles, {} grey octants\n{:<34}{:>16}{:>16}{:>14}\n",
            depth, mesh.name, grouped(mesh.mesh.triangles.size()), grouped(grey), "", "missed", "extra", "queries");
        for (const OctantContender& contender : contenders_) {
            if (contender.threads > 1) continue;
            Candidate candidate(contender, levels);
            std::uint64_t missed = 0, extra = 0, queries = 0;
            for (int level = 0; level < depth; ++level)
                queries += candidate
                               .grow_level([&](unsigned truth, unsigned found) {
                                   missed += std::uint64_t(std::popcount(truth & ~found));
                                   extra += std::uint64_t(std::popcount(found & ~truth));
                               })
                               .queries;
            const auto share = [&](std::uint64_t n) { return 100 * double(n) / double(grey); };
            say("  {:<32}{:>7} {:>6.2f} %{:>7} {:>6.2f} %{:>14}\n", contender.name, missed, share(missed), extra,
                share(extra), grouped(queries));
            record("misses", mesh, contender.name, grey, double(missed), double(extra));
        }
        say("\n");
    }

    OctantsOptions options_;
    std::filesystem::path data_;
    std::vector<OctantContender> contenders_;
    CsvFile csv_;
};

int bench_octants(const OctantsOptions& options)
{
    const std::vector<std::string> parts{"", "speed", "trees", "misses"};
    if (std::find(parts.begin(), parts.end(), options.only) == parts.end())
        usage(fmt::format("--only {}: valid are speed, trees, misses", options.only));
    check_range("--repeats", options.repeats, 1, 1000);
    if (!(options.limit_s > 0)) usage(fmt::format("--limit {}: must be above 0 seconds", options.limit_s));
    check_files({{"--csv", options.csv}});
    OctantBench(options).run();
    return 0;
}

} // namespace

void add_octants(Arguments bench)
{
    Arguments sub = bench.add_command("octants", "Batches of octant queries: which octants does the surface "
                                                 "intersect?");
    auto options = std::make_shared<OctantsOptions>();
    sub.add_option("--data DIR", options->data, "folder with meshes/ (default: $ONCOLLIDE_DATA, else ../shared/data)");
    sub.add_option("--gpu N", options->gpu, "number of the GPU ('oncollide doctor' lists them)");
    sub.add_option("--repeats N", options->repeats, "number of runs; each batch's least time counts (default 5)");
    sub.add_option("--only PART", options->only, "run only one part: speed, trees or misses");
    sub.add_option("--limit S", options->limit_s, "skip batches that would take longer (seconds, default 2)");
    sub.add_option("--csv FILE", options->csv, "write one row per figure");
    sub.action([options] { return bench_octants(*options); });
}

} // namespace oncollide::tools
