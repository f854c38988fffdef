// How fast is the question "which octants does the surface enter?" answered, by whom, in batches of which size?
#include "bench.hpp"
#include "octant_levels.hpp"
#include "options.hpp"

#include <algorithm>
#include <chrono>

#include <oncollide/narrowphase/gpu.hpp>
#include <oncollide/scenes/error.hpp>
#include <oncollide/scenes/output_file.hpp>

namespace oncollide::tools {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point from)
{
    return std::chrono::duration<double, std::milli>(Clock::now() - from).count();
}

/// Grows the whole tree in a backend, level by level. Returns the time, ms.
double grow_whole(OcclusionBackend& backend, const OctantLevels& levels, int depth, int threads, BatchWork& sum)
{
    sum = {};
    const Clock::time_point from = Clock::now();
    Ocst tree(levels.root(), depth, 0);
    std::vector<OctantRow> rows;
    std::vector<OctantAnswer> answers;
    for (int level = 0; level < depth; ++level) {
        rows.clear();
        for (CellKey cell : levels.cells(level)) rows.push_back(tree.row(0, cell));
        answers.resize(rows.size());
        const BatchWork work = backend.ask(rows, threads, answers);
        sum.gpu_ms += work.gpu_ms, sum.wait_ms += work.wait_ms, sum.bytes += work.bytes, sum.repeats += work.repeats;
        for (std::size_t i = 0; i < rows.size(); ++i) tree.expand(rows[i].cell, answers[i], 1);
    }
    return milliseconds_since(from);
}

} // namespace

int bench_octants(const OctantsOptions& options)
{
    const std::filesystem::path data = data_folder(options.data);
    for (const OctantMesh& mesh : octant_meshes(data)) {
        if (mesh.mesh.triangles.size() < 5000) continue;
        OctantLevels levels(mesh.mesh, 8);
        for (int depth = 5; depth <= 7; ++depth) {
            for (int k = 0; k < 3; ++k) {
                auto backend = k < 2 ? make_cpu_backend() : make_gl_compute_backend({});
                double best = 1e9, gpu = 0;
                BatchWork work;
                for (int r = 0; r < options.repeats; ++r) {
                    backend->attach(0, levels.surface());
                    const double ms = grow_whole(*backend, levels, depth, k == 1 ? 2 : 1, work);
                    backend->detach(0);
                    if (ms < best) best = ms, gpu = work.gpu_ms;
                }
                say("{} {} depth {} {}: {:.3f} ms, gpu {:.3f}\n", mesh.name, mesh.mesh.triangles.size(), depth,
                    backend->name(), best, gpu);
            }
        }
    }
    return 0;
}

} // namespace oncollide::tools
