// oncollide bench octants: speed and errors of each backend in finding the octants that a surface intersects.
#include "bench/bench.hpp"
#include "bench/paper/octant_levels.hpp"
#include "cli/options.hpp"
#include "common/text.hpp"

#include <algorithm>
#include <bit>
#include <functional>
#include <memory>
#include <optional>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/gl/gpu.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::tools {
namespace {

struct OctantsOptions {
    std::string data, only, csv;
    int gpu = -1, repeats = 5;
    double limit_s = 2; ///< batches that would take longer are skipped
};

/// A backend in one of its variants.
struct OctantContender {
    std::string name;
    std::function<std::unique_ptr<OcclusionBackend>()> make;
    int threads = 1;
    bool lists = true; ///< false: it draws whole meshes, without using lists
};

std::vector<OctantContender> contenders(int gpu)
{
    using Query = GlQueryOptions;
    std::vector<OctantContender> all;
    all.push_back({"cpu", make_cpu_backend});
    if (hardware_threads() > 1)
        all.push_back({fmt::format("cpu, {} threads", hardware_threads()), make_cpu_backend, hardware_threads()});
    all.push_back({"gl-compute", [gpu] { return make_gl_compute_backend({.gpu = gpu}); }});
    const auto add = [&](std::string what, Query query) {
        query.gpu = gpu;
        all.push_back({fmt::format("gl-query {} px, {}", query.viewport, what),
                       [query] { return make_gl_query_backend(query); }, 1, query.draw == Query::Draw::inherited});
    };
    for (int viewport : {8, 16, 32, 64}) {
        add("soup", {.viewport = viewport, .primitives = Query::Primitives::soup, .draw = Query::Draw::mesh});
        add("indexed", {.viewport = viewport, .primitives = Query::Primitives::indexed, .draw = Query::Draw::mesh});
        add("strips", {.viewport = viewport, .primitives = Query::Primitives::strips, .draw = Query::Draw::mesh});
    }
    add("inherited", {.draw = Query::Draw::inherited});
    add("inherited, inflated", {.draw = Query::Draw::inherited, .inflated = true});
    return all;
}

/// A contender with a mesh, and the tree that it grew along the true cells.
class Candidate {
public:
    Candidate(const OctantContender& contender, const OctantLevels& levels)
        : contender_(contender), levels_(levels), backend_(contender.make())
    {
        start_again();
    }

    void start_again()
    {
        if (backend_->attached(0)) backend_->detach(0);
        tree_.emplace(levels_.root(), levels_.depth() + 1, 0);
        backend_->attach(0, levels_.surface());
        grown_ = 0;
    }

    /// Queries the cells of the next level and grows the tree; `see` receives each cell's true and found octants.
    template <class See>
    BatchWork grow_level(See see)
    {
        const auto& cells = levels_.level(grown_++);
        rows_.clear();
        for (const auto& cell : cells) rows_.push_back(row(cell.key));
        results_.resize(rows_.size());
        const BatchWork work = backend_->run(rows_, contender_.threads, results_);
        for (std::size_t i = 0; i < cells.size(); ++i) {
            see(cells[i].truth, results_[i].grey);
            results_[i].grey = cells[i].truth;
            tree_->expand(cells[i].key, results_[i], 1);
        }
        return work;
    }

    /// `count` queries of one level: the last level with at least this many cells, if there is one. Returns the least
    /// time of `repeats`, ms.
    double measure(std::size_t count, int repeats)
    {
        int level = 0;
        while (level + 1 < levels_.depth() && levels_.level(level).size() < count) ++level;
        while (contender_.lists && grown_ < level) grow_level([](auto...) {});
        rows_.clear();
        const auto& cells = levels_.level(level);
        for (std::size_t i = 0; i < count; ++i) // spread over the level; repeated if it has too few cells
            rows_.push_back(row(cells[cells.size() >= count ? i * cells.size() / count : i % cells.size()].key));
        results_.resize(count);
        double best = 1e300;
        for (int repeat = 0; repeat < repeats; ++repeat) {
            const Clock::time_point from = Clock::now();
            backend_->run(rows_, contender_.threads, results_);
            best = std::min(best, milliseconds_since(from));
            for (const OctantResult& result : results_)
                if (result.list != all_triangles) backend_->release(0, result.list);
        }
        return best;
    }

private:
    OctantRow row(CellKey cell) const
    {
        if (contender_.lists) return tree_->row(0, cell);
        return {0, cell, all_triangles, false};
    }

    const OctantContender& contender_;
    const OctantLevels& levels_;
    std::unique_ptr<OcclusionBackend> backend_;
    std::optional<Ocst> tree_;
    int grown_ = 0; ///< levels
    std::vector<OctantRow> rows_;
    std::vector<OctantResult> results_;
};

class OctantBench {
public:
    explicit OctantBench(const OctantsOptions& options)
        : options_(options), data_(data_folder(options.data)), contenders_(contenders(options.gpu))
    {
        if (!options.csv.empty()) csv_.emplace(options.csv, "part,mesh,triangles,backend,n,value,other");
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
        if (csv_) csv_->commit();
    }

private:
    bool wanted(const std::string& part) const { return options_.only.empty() || options_.only == part; }

    void record(const char* part, const NamedMesh& mesh, const std::string& backend, std::size_t n, double value,
                double other)
    {
        if (csv_) csv_->row(part, mesh.name, mesh.mesh.triangles.size(), Quoted{backend}, n, value, other);
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
                const double ms = candidate.measure(rows, row_ms * double(rows) > 200 ? 1 : options_.repeats);
                row_ms = ms / double(rows);
                say("{:>12.4f}", 8e-3 * double(rows) / ms);
                std::cout.flush();
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
                double best = 1e300, gpu = 0;
                for (int repeat = 0; repeat < options_.repeats; ++repeat) {
                    candidate.start_again();
                    double gpu_ms = 0;
                    const Clock::time_point from = Clock::now();
                    for (int level = 0; level < depth; ++level) gpu_ms += candidate.grow_level([](auto...) {}).gpu_ms;
                    if (const double ms = milliseconds_since(from); ms < best) best = ms, gpu = gpu_ms;
                }
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
    std::optional<CsvFile> csv_;
};

/// Batches of octant queries with every backend.
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
    sub.add_option("--data", options->data, "folder with meshes/ (default: $ONCOLLIDE_DATA, else ../shared/data)")
        .type_name("DIR");
    sub.add_option("--gpu", options->gpu, "number of the GPU ('oncollide doctor' lists them)").type_name("N");
    sub.add_option("--repeats", options->repeats,
                   "number of runs; each batch's least time counts (default "
                   "5)")
        .type_name("N");
    sub.add_option("--only", options->only, "run only one part: speed, trees or misses").type_name("PART");
    sub.add_option("--limit", options->limit_s, "skip batches that would take longer (seconds, default 2)")
        .type_name("S");
    sub.add_option("--csv", options->csv, "write one row per figure").type_name("FILE");
    sub.action([options] { return bench_octants(*options); });
}

} // namespace oncollide::tools
