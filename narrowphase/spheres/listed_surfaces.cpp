#include <oncollide/narrowphase/spheres/listed_surfaces.hpp>

#include <algorithm>

#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/base/threads/parallel.hpp>

namespace oncollide {

void ListedSurfaces::attach(std::uint32_t tree, Surface surface)
{
    if (trees_.size() <= tree) trees_.resize(tree + 1);
    trees_[tree].emplace(Tree{std::move(surface), {}});
}

void ListedSurfaces::detach(std::uint32_t tree)
{
    if (attached(tree)) trees_[tree].reset();
}

void ListedSurfaces::find(std::span<const OctantRow> rows, const Find& how, int threads)
{
    workers_.resize(static_cast<std::size_t>(std::max(threads, 1)));
    for (Worker& worker : workers_) worker.ids.clear(), worker.masks.clear();
    found_.resize(rows.size());
    parallel_chunks(rows.size(), 16, threads, [&](std::size_t begin, std::size_t end, int thread) {
        for (std::size_t i = begin; i < end; ++i) found_[i] = test(rows[i], how, static_cast<std::uint32_t>(thread));
    });
}

ListedSurfaces::Found ListedSurfaces::test(const OctantRow& row, const Find& how, std::uint32_t worker_index)
{
    static OctantTest* const octant_test = ONCOLLIDE_CHOOSE_TO_AVX2(octant_test);
    const Surface& surface = trees_[row.tree]->surface;
    OctantCell cell = octant_cell(surface.root, row.cell);
    cell.slack += how.inflation * *std::max_element(cell.half, cell.half + 3);
    Worker& worker = workers_[worker_index];
    const TriangleSpan span = span_of(row.tree, row.list, octant_of(row.cell));
    const std::size_t offset = worker.ids.size();
    worker.ids.resize(offset + span.count), worker.masks.resize(offset + span.count);
    const std::uint32_t count = octant_test(surface.primitives.data(), surface.boxes || how.boxes, span, cell,
                                            worker.ids.data() + offset, worker.masks.data() + offset);
    std::uint8_t entered = 0;
    for (std::size_t i = offset; i < offset + count; ++i) entered |= worker.masks[i];
    // A triangle's box may overlap an octant that is completely inside and that the triangle does not enter.
    const unsigned inside = octants_inside(surface.inside, cell, how.boxes ? 0 : entered);
    const std::uint32_t kept = row.keep_list || how.all ? count : 0;
    worker.ids.resize(offset + kept), worker.masks.resize(offset + kept);
    return {worker_index, static_cast<std::uint32_t>(offset), kept, entered, static_cast<std::uint8_t>(inside)};
}

TriangleSpan ListedSurfaces::triangles(std::size_t row, unsigned octant) const
{
    const Found& found = found_[row];
    const Worker& worker = workers_[found.worker];
    return {worker.ids.data() + found.offset, worker.masks.data() + found.offset, found.count, octant};
}

ListId ListedSurfaces::keep(std::uint32_t tree, std::size_t row)
{
    const TriangleSpan found = triangles(row, 0);
    return trees_[tree]->lists.add(found.ids, found.masks, found.count);
}

TriangleSpan ListedSurfaces::span_of(std::uint32_t tree, ListId list, unsigned octant) const
{
    const auto all = static_cast<std::uint32_t>(trees_[tree]->surface.primitives.size());
    return list == all_triangles ? TriangleSpan{nullptr, nullptr, all, octant} : trees_[tree]->lists.span(list, octant);
}

void ListedSurfaces::read(std::span<const ListRead> reads, std::vector<std::uint32_t>& triangles,
                          std::vector<std::size_t>& ends) const
{
    for (const ListRead& r : reads) {
        const TriangleSpan span = span_of(r.tree, r.list, r.octant);
        for (std::uint32_t i = 0; i < span.count; ++i)
            if (!span.ids || span.masks[i] >> r.octant & 1) triangles.push_back(span.ids ? span.ids[i] : i);
        ends.push_back(triangles.size());
    }
}

std::size_t ListedSurfaces::bytes() const
{
    std::size_t sum = 0;
    for (const auto& tree : trees_)
        if (tree) sum += tree->surface.bytes() + tree->lists.bytes();
    return sum;
}

} // namespace oncollide
