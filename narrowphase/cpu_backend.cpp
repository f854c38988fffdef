#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include <oncollide/broadphase/cpu_features.hpp>
#include <oncollide/narrowphase/octant_cell.hpp>
#include <oncollide/narrowphase/triangle_lists.hpp>
#include <oncollide/scenes/error.hpp>
#include <oncollide/scenes/parallel.hpp>

namespace oncollide {

namespace {

OctantTest* octant_test_for(InstructionSet set)
{
    switch (set) {
    case InstructionSet::avx512:
        return avx512::octant_test();
    case InstructionSet::avx2:
        return avx2::octant_test();
    default:
        return baseline::octant_test();
    }
}

class CpuBackend final : public OcclusionBackend {
public:
    std::string name() const override { return fmt::format("cpu ({})", name_of(instruction_set())); }
    double reach(double) const override { return 0; }

    void attach(std::uint32_t tree, Surface surface) override
    {
        if (trees_.size() <= tree) trees_.resize(tree + 1);
        trees_[tree].emplace(Tree{std::move(surface), {}});
    }
    bool attached(std::uint32_t tree) const override { return tree < trees_.size() && trees_[tree]; }
    void detach(std::uint32_t tree) override
    {
        if (attached(tree)) trees_[tree].reset();
    }

    /// Answers at once: there is nobody else to do the work.
    void submit(std::span<const OctantRow> rows, int threads) override
    {
        answers_.resize(rows.size());
        workers_.resize(static_cast<std::size_t>(std::max(threads, 1)));
        for (Worker& worker : workers_) worker.ids.clear(), worker.masks.clear();
        found_.resize(rows.size());
        parallel_chunks(rows.size(), 16, threads, [&](std::size_t begin, std::size_t end, int thread) {
            for (std::size_t i = begin; i < end; ++i)
                answers_[i] = {test(rows[i], static_cast<std::uint32_t>(thread), found_[i]), all_triangles};
        });
        // Lists are stored in the order of the rows, so that threads leave no trace in them.
        for (std::size_t i = 0; i < rows.size(); ++i) {
            if (!rows[i].keep_list) continue;
            const Worker& worker = workers_[found_[i].worker];
            answers_[i].list = trees_[rows[i].tree]->lists.add(worker.ids.data() + found_[i].offset,
                                                               worker.masks.data() + found_[i].offset, found_[i].count);
        }
    }

    BatchWork collect(std::span<OctantAnswer> answers) override
    {
        ONCOLLIDE_ASSERT(answers.size() == answers_.size());
        std::copy(answers_.begin(), answers_.end(), answers.begin());
        return {};
    }

    void release(std::uint32_t tree, ListId list) override { trees_[tree]->lists.release(list); }

    void read(std::span<const ListRead> reads, std::vector<std::uint32_t>& triangles,
              std::vector<std::size_t>& ends) override
    {
        for (const ListRead& r : reads) {
            const TriangleSpan span = span_of(r.tree, r.list, r.octant);
            for (std::uint32_t i = 0; i < span.count; ++i)
                if (!span.ids || span.masks[i] >> r.octant & 1) triangles.push_back(span.ids ? span.ids[i] : i);
            ends.push_back(triangles.size());
        }
    }

    std::size_t bytes() const override
    {
        std::size_t sum = 0;
        for (const auto& tree : trees_)
            if (tree) sum += tree->surface.bytes() + tree->lists.bytes();
        return sum;
    }

private:
    struct Tree {
        Surface surface;
        TriangleLists lists;
    };
    struct Worker { ///< lists found by one thread, until they are stored
        std::vector<std::uint32_t> ids;
        std::vector<std::uint8_t> masks;
    };
    struct Found {
        std::uint32_t worker, offset, count;
    };

    TriangleSpan span_of(std::uint32_t tree, ListId list, unsigned octant) const
    {
        const auto all = static_cast<std::uint32_t>(trees_[tree]->surface.primitives.size());
        return list == all_triangles ? TriangleSpan{nullptr, nullptr, all, octant}
                                     : trees_[tree]->lists.span(list, octant);
    }

    std::uint8_t test(const OctantRow& row, std::uint32_t worker_index, Found& found)
    {
        const Surface& surface = trees_[row.tree]->surface;
        const OctantCell cell = octant_cell(surface.root, row.cell);
        Worker& worker = workers_[worker_index];
        const TriangleSpan span = span_of(row.tree, row.list, octant_of(row.cell));
        const std::size_t offset = worker.ids.size();
        worker.ids.resize(offset + span.count), worker.masks.resize(offset + span.count);
        const std::uint32_t count = test_(surface.primitives.data(), surface.boxes, span, cell,
                                          worker.ids.data() + offset, worker.masks.data() + offset);
        std::uint8_t grey = 0;
        for (std::size_t i = offset; i < offset + count; ++i) grey |= worker.masks[i];
        found = {worker_index, static_cast<std::uint32_t>(offset), count};
        const std::size_t kept = row.keep_list ? offset + count : offset;
        worker.ids.resize(kept), worker.masks.resize(kept);
        return static_cast<std::uint8_t>(grey | octants_inside(surface.inside, cell, grey));
    }

    OctantTest* test_ = octant_test_for(instruction_set());
    std::vector<std::optional<Tree>> trees_;
    std::vector<Worker> workers_;
    std::vector<Found> found_;
    std::vector<OctantAnswer> answers_;
};

} // namespace

std::unique_ptr<OcclusionBackend> make_cpu_backend()
{
    return std::make_unique<CpuBackend>();
}

} // namespace oncollide
