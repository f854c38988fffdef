#include "view/page_trees.hpp"

#include <algorithm>

#include "trees/box_levels.hpp"
#include "trees/grown_tree.hpp"

namespace oncollide::tools {
namespace {

constexpr int deepest = 8;
constexpr std::size_t bytes_of_sphere = 12, bytes_of_box = 32;

} // namespace

std::size_t PageTrees::bytes() const
{
    std::size_t sum = 0;
    for (const Level& level : spheres) sum += level.volumes.size() * bytes_of_sphere;
    for (const Level& level : boxes) sum += level.volumes.size() * bytes_of_box;
    return sum;
}

PageTrees make_page_trees(std::shared_ptr<const Geometry> geometry, std::size_t most, int threads)
{
    PageTrees trees;
    if (!has_spheres(geometry->data)) return trees;
    const Settings settings{.depth = deepest, .threads = threads};
    // A level has about four times, and at most eight times, as many volumes as the level above.
    int levels = 0;
    for (std::size_t last = 1; levels < deepest && 4 * last <= most; ++levels) {
        const GrownTree tree(geometry, settings, levels + 1);
        const std::size_t count = tree.level(tree.depth()).size();
        if (count > most) break;
        last = std::max<std::size_t>(count, 1);
    }
    const GrownTree tree(geometry, settings, levels);
    for (int level = 0; level <= tree.depth(); ++level)
        trees.spheres.push_back({tree.spheres(level), tree.certified_reach(level)});

    const auto* mesh = std::get_if<Mesh>(&geometry->data);
    if (!mesh) return trees;
    ObbTree boxes(*mesh);
    for (std::vector<CoveringVolume>& volumes : box_levels(boxes, most)) {
        double largest = 0;
        for (const CoveringVolume& v : volumes) largest = std::max(largest, v.radius());
        trees.boxes.push_back({std::move(volumes), 2 * largest});
    }
    return trees;
}

} // namespace oncollide::tools
