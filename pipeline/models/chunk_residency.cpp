#include <oncollide/pipeline/models/chunk_residency.hpp>

#include <algorithm>

namespace oncollide {

/// Drops the least recently needed chunks until at most `down_to` bytes are held.
void ChunkResidency::drop_chunks(std::size_t down_to) const
{
    struct Candidate : HeldChunks::Held {
        HeldChunks* of;
    };
    std::vector<Candidate> candidates;
    std::vector<HeldChunks::Held> held;
    const auto add = [&](HeldChunks& of) {
        held.clear();
        of.add_held(held);
        for (const HeldChunks::Held& chunk : held) candidates.push_back({chunk, &of});
    };
    const PreparedTrees::Lock lock = prepared_.lock();
    for (const Model* model : trees_) add(*model->obb_tree());
    for (const Model* model : grids_)
        if (HeldChunks* grid = model->held_grid()) add(*grid);
    prepared_.each(add);
    std::ranges::stable_sort(candidates, {}, [](const Candidate& c) { return c.needed; });
    for (const Candidate& candidate : candidates) {
        if (budget_.held() <= down_to) return;
        candidate.of->drop(candidate.chunk);
    }
}

std::uint64_t ChunkResidency::nodes() const
{
    std::uint64_t sum = 0;
    for (const Model* model : trees_) sum += model->obb_tree()->nodes();
    return sum;
}

std::size_t ChunkResidency::bytes() const
{
    std::size_t sum = 0;
    for (const Model* model : grids_) sum += model->grid_bytes();
    for (const Model* model : trees_) sum += model->obb_tree()->bytes();
    return sum;
}

} // namespace oncollide
