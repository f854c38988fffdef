#include <oncollide/pipeline/models/prepared_trees.hpp>

#include <algorithm>
#include <new>

namespace oncollide {

void PreparedTrees::prepare(std::vector<PrefetchPart> parts)
{
    if (!thread_) thread_ = std::make_unique<Prefetcher>([this](const PrefetchPart& part) { prepare(part); });
    thread_->set(std::move(parts));
}

void PreparedTrees::begin(std::uint32_t frame)
{
    if (!thread_) return;
    const Lock held = lock();
    frame_ = frame;
}

std::vector<PreparedTrees::Prepared>::iterator PreparedTrees::find(const Model& model)
{
    return std::ranges::find(trees_, &model, &Prepared::model);
}

/// Runs in the thread. Ignores faults: they are reported when a pair needs the chunk.
void PreparedTrees::prepare(const PrefetchPart& part)
{
    constexpr std::uint32_t fine = 64; // triangles: smaller nodes grow fast enough during a traversal
    const Model& model = *part.model;
    try {
        ObbTree* tree = nullptr;
        {
            const Lock held = lock();
            if (const auto found = find(model); found != trees_.end())
                tree = found->tree.get(), found->frame = frame_;
            else
                tree = model.obb_tree();
        }
        if (!tree) {
            const auto& cooked = std::get<std::shared_ptr<const CookedMesh>>(model.geometry().data);
            auto made = std::make_unique<ObbTree>(cooked, chunks_);
            const Lock held = lock();
            tree = model.obb_tree();
            if (!tree) tree = made.get(), trees_.push_back({&model, std::move(made), frame_});
        }
        tree->grow_in(part.box, fine);
    } catch (const ChunkFault&) {
    } catch (const std::bad_alloc&) {
    }
}

std::unique_ptr<ObbTree> PreparedTrees::take(const Model& model)
{
    const auto found = find(model);
    if (found == trees_.end()) return nullptr;
    std::unique_ptr<ObbTree> tree = std::move(found->tree);
    trees_.erase(found);
    return tree;
}

void PreparedTrees::forget(const Model& model)
{
    if (thread_) thread_->forget(model);
    take(model);
}

void PreparedTrees::drop(std::uint32_t frame, std::uint32_t age)
{
    std::erase_if(trees_, [&](const Prepared& prepared) { return frame - prepared.frame >= age; });
}

} // namespace oncollide
