#include <oncollide/pipeline/models/obb_residency.hpp>
#include <oncollide/pipeline/settings_rules.hpp>

#include <algorithm>
#include <limits>

namespace oncollide {

void ObbResidency::add(Model& model)
{
    if (reads_on_demand(settings_)) model.read_on_demand(counters_.chunks);
    if (model.terrain() || (model.file() && model.map())) chunks_.add_grid(model);
}

void ObbResidency::drop(Model& model)
{
    {
        const Prefetcher::Pause pause = prepared_.pause();
        const PreparedTrees::Lock lock = prepared_.lock();
        prepared_.forget(model);
        if (drop_tree(model)) std::erase(with_trees_, &model);
    }
    chunks_.remove_grid(model);
}

ObbResidency::Room ObbResidency::all_grown(const Model& model)
{
    return {ObbTree::most_nodes(model.triangles()), ObbTree::most_bytes(model.triangles())};
}

bool ObbResidency::admit(Model& model, std::uint32_t frame)
{
    model.need_obb_tree(frame);
    if (model.obb_tree()) return true;
    if (model.map()) return model.cells(), true;
    if (model.terrain()) return model.heights(), true;
    if (!model.has_triangles()) return true;
    const auto left = [](auto budget, auto held) -> decltype(budget) {
        if (budget == 0) return std::numeric_limits<decltype(budget)>::max();
        return budget > held ? budget - held : 0;
    };
    const Room more = all_grown(model);
    if (more.nodes > left(std::uint64_t(settings_.node_budget), spheres_.cells() + reserved_.nodes) ||
        more.bytes > left(settings_.memory_budget, spheres_.bytes() + reserved_.bytes))
        return false;
    if (!model.unreadable().empty()) return false;
    try {
        make(model, more);
    } catch (const ChunkFault& fault) {
        model.unreadable_ = fault.what();
        return false;
    }
    return true;
}

ObbTree& ObbResidency::tree(Model& model, std::uint32_t frame)
{
    model.need_obb_tree(frame);
    if (!model.obb_tree()) make(model, all_grown(model));
    return *model.obb_tree();
}

void ObbResidency::make(Model& model, const Room& room)
{
    const PreparedTrees::Lock lock = prepared_.lock();
    model.obb_tree_ = prepared_.take(model);
    if (!model.obb_tree_)
        model.make_obb_tree(reads_on_demand(settings_) ? &counters_.chunks : nullptr, counters_.totals);
    model.has_budget_ = settings_.node_budget != 0 || settings_.memory_budget != 0;
    with_trees_.push_back(&model);
    if (model.obb_tree_->chunked()) chunks_.add(model);
    reserved_.nodes += room.nodes, reserved_.bytes += room.bytes;
}

/// Drops a model's OBB tree and releases its reserved room. Returns the number of nodes dropped.
std::uint64_t ObbResidency::drop_tree(Model& model)
{
    if (!model.obb_tree_) return 0;
    const Room less = all_grown(model);
    reserved_.nodes -= less.nodes, reserved_.bytes -= less.bytes;
    const std::uint64_t dropped = model.obb_tree_->nodes();
    if (model.obb_tree_->chunked()) chunks_.remove(model);
    model.drop_obb_tree();
    return dropped;
}

std::optional<std::uint64_t> ObbResidency::collapse(std::uint32_t frame, std::uint32_t age)
{
    const Prefetcher::Pause pause = prepared_.pause(false);
    if (pause.failed()) return std::nullopt;
    const PreparedTrees::Lock lock = prepared_.lock();
    prepared_.drop(frame, age);
    std::uint64_t dropped = 0;
    std::erase_if(with_trees_, [&](Model* model) {
        if (frame - model->obb_tree_needed() < age) return false;
        dropped += drop_tree(*model);
        return true;
    });
    return dropped;
}

std::uint64_t ObbResidency::nodes() const
{
    return counters_.totals.nodes + chunks_.nodes();
}

std::size_t ObbResidency::bytes() const
{
    return counters_.totals.bytes + chunks_.bytes();
}

} // namespace oncollide
