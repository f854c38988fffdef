#include <oncollide/pipeline/refine/gpu_trees.hpp>

#include <oncollide/base/threads/parallel.hpp>

namespace oncollide {

std::uint32_t GpuTrees::hold_first(MeshWalks& walks, std::uint32_t number, const Model& model, std::uint32_t frame)
{
    if (by_number_.size() <= number) by_number_.resize(number + std::size_t{1});
    Held& held = by_number_[number];
    const auto tree = walks.hold(*model.obb_tree(), frame);
    held = {call_, tree.value_or(none)};
    if (tree) {
        if (of_slots_.size() <= *tree) of_slots_.resize(*tree + std::size_t{1});
        of_slots_[*tree] = model.obb_tree();
    }
    return held.tree;
}

void GpuTrees::miss(std::span<const WantedNode> wanted)
{
    for (const WantedNode& box : wanted)
        if (box.tree < of_slots_.size() && of_slots_[box.tree])
            missed_.push_back({of_slots_[box.tree]->identity(), box});
}

void GpuTrees::grow_missed(int threads)
{
    parallel_chunks(missed_.size(), 16, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto& [identity, box] = missed_[i];
            ObbTree* const tree = box.tree < of_slots_.size() ? of_slots_[box.tree] : nullptr;
            if (tree && tree->identity() == identity) tree->child(box.node, box.box);
        }
    });
    missed_.clear();
}

} // namespace oncollide
