#include "bench/gpu/octant_candidate.hpp"

#include <fmt/format.h>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/gl/gpu.hpp>

#include "common/statistics.hpp"

namespace oncollide::tools {

std::vector<OctantContender> octant_contenders(int gpu, bool each)
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
    if (!each)
        std::erase_if(all, [](const OctantContender& c) {
            return c.threads > 1 || (c.name.starts_with("gl-query") && c.name != "gl-query 16 px, soup" &&
                                     c.name != "gl-query 16 px, inherited");
        });
    return all;
}

Candidate::Candidate(const OctantContender& contender, const OctantLevels& levels)
    : contender_(contender), levels_(levels), backend_(contender.make())
{
    start_again();
}

void Candidate::start_again()
{
    if (backend_->attached(0)) backend_->detach(0);
    tree_.emplace(levels_.root(), levels_.depth() + 1, 0);
    backend_->attach(0, levels_.surface());
    grown_ = 0;
}

OctantTime Candidate::measure(std::size_t count, int repeats)
{
    int level = 0;
    while (level + 1 < levels_.depth() && levels_.level(level).size() < count) ++level;
    while (contender_.lists && grown_ < level) grow_level([](auto...) {});
    rows_.clear();
    const auto& cells = levels_.level(level);
    for (std::size_t i = 0; i < count; ++i) // spread over the level; repeated if it has too few cells
        rows_.push_back(row(cells[cells.size() >= count ? i * cells.size() / count : i % cells.size()].key));
    results_.resize(count);
    OctantTime best;
    for (int repeat = 0; repeat < repeats; ++repeat) {
        const Clock::time_point from = Clock::now();
        const BatchWork work = backend_->run(rows_, contender_.threads, results_);
        if (const double ms = milliseconds_since(from); ms < best.ms) best = {ms, work.gpu_ms};
        for (const OctantResult& result : results_)
            if (result.list != all_triangles) backend_->release(0, result.list);
    }
    return best;
}

OctantTime Candidate::measure_tree(int depth, int repeats)
{
    OctantTime best;
    for (int repeat = 0; repeat < repeats; ++repeat) {
        start_again();
        double gpu_ms = 0;
        const Clock::time_point from = Clock::now();
        for (int level = 0; level < depth; ++level) gpu_ms += grow_level([](auto...) {}).gpu_ms;
        if (const double ms = milliseconds_since(from); ms < best.ms) best = {ms, gpu_ms};
    }
    return best;
}

OctantRow Candidate::row(CellKey cell) const
{
    if (contender_.lists) return tree_->row(0, cell);
    return {0, cell, all_triangles, false};
}

} // namespace oncollide::tools
