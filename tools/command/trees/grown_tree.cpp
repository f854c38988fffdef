#include "trees/grown_tree.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

bool has_spheres(const GeometryData& data)
{
    const auto* shape = std::get_if<Shape>(&data);
    return !std::holds_alternative<Terrain>(data) && !(shape && std::holds_alternative<HalfSpace>(*shape));
}

GrownTree::GrownTree(std::shared_ptr<const Geometry> geometry, const Settings& settings, std::optional<int> levels,
                     std::size_t most)
    : settings_(settings), models_(settings_, make_cpu_backend()),
      model_(models_[models_.add(geometry)]), levels_{{root_cell}}
{
    const Ocst& tree = models_.spheres(model_, models_.max_error(model_, model_));
    std::vector<CellRequest> requests;
    for (int l = 0; l < std::min(tree.depth(), levels.value_or(tree.depth())); ++l) {
        requests.clear();
        for (const CellKey cell : levels_.back()) requests.push_back({model_.number(), cell});
        std::sort(requests.begin(), requests.end());
        models_.submit(requests, thread_count(settings_));
        models_.grow(0);
        std::vector<CellKey>& next = levels_.emplace_back();
        tree.for_each_cell([&](CellKey cell, bool) {
            if (level_of(cell) == l + 1) next.push_back(cell);
        });
        if (next.size() > most)
            throw Error(
                ErrorKind::usage,
                fmt::format("level {} of '{}' has {} cells, but at most {} are supported; give a smaller --level or "
                            "--depth, or a larger --max-error",
                            l + 1, geometry->name, next.size(), most));
    }
}

std::vector<CoveringVolume> GrownTree::spheres(int level) const
{
    std::vector<CoveringVolume> spheres;
    for (const CellKey cell : this->level(level))
        spheres.push_back(CoveringVolume::of_ball(tree().centre(cell), tree().radius(level)));
    return spheres;
}

double GrownTree::certified_reach(int level) const
{
    return 2 * tree().radius(level) + tree().error(level);
}

const GrownTree& GrownTrees::operator[](GeometryId id)
{
    const GeometryList& now = scene_.geometries;
    trees_.resize(now.size());
    for (const std::uint32_t g : now.deforming())
        if (g >= geometries_.size() || geometries_.share(g) != now.share(g)) trees_[g].reset();
    geometries_ = now;
    std::unique_ptr<GrownTree>& tree = trees_[index(id)];
    if (!tree)
        tree = std::make_unique<GrownTree>(scene_.geometries.share(index(id)),
                                           Settings{.depth = std::max(depth_, 1), .threads = threads_}, depth_);
    return *tree;
}

} // namespace oncollide::tools
