#include "spheres/grown_tree.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide::tools {

GrownTree::GrownTree(const Scene& scene, const Settings& settings, std::size_t most)
    : settings_(settings), models_(settings_, make_cpu_backend()),
      model_(models_[models_.add(scene.geometries.share(0))]), levels_{{root_cell}}
{
    const Ocst& tree = models_.spheres(model_);
    std::vector<CellRequest> requests;
    for (int l = 0; l < tree.depth(); ++l) {
        requests.clear();
        for (const CellKey cell : levels_.back()) requests.push_back({0, cell});
        std::sort(requests.begin(), requests.end());
        models_.submit(requests, 1);
        models_.grow(0);
        std::vector<CellKey>& next = levels_.emplace_back();
        tree.for_each_cell([&](CellKey cell, bool) {
            if (level_of(cell) == l + 1) next.push_back(cell);
        });
        if (next.size() > most)
            throw Error(ErrorKind::usage, fmt::format("depth {}: level {} has {} spheres, at most {} are listed; give "
                                                      "a smaller --depth or a larger --max-error",
                                                      tree.depth(), l + 1, next.size(), most));
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

} // namespace oncollide::tools
