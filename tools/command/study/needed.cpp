#include "study/play.hpp"

#include <algorithm>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/world/world_access.hpp>

#include "cli/progress.hpp"
#include "trees/grown_tree.hpp"

namespace oncollide::tools {
namespace {

constexpr int no_ageing = 1'000'000; ///< frames

/// Number of nodes in the whole OBB tree of a mesh.
std::uint64_t all_boxes(const Mesh& mesh)
{
    ObbTree tree(mesh);
    std::vector<std::uint32_t> open{ObbTree::root};
    while (!open.empty()) {
        const std::uint32_t node = open.back();
        open.pop_back();
        for (unsigned k = 0; k < tree.node(node).lanes; ++k)
            if (!(tree.node(node).leaves >> k & 1)) open.push_back(tree.child(node, k));
    }
    return tree.nodes();
}

/// Fully grown trees; each is counted once.
class WholeModel {
public:
    explicit WholeModel(const Scene& scene) : scene_(scene), boxes_(scene.geometries.size()), cells_(boxes_.size()) {}

    std::uint64_t boxes(std::uint32_t geometry)
    {
        if (!boxes_[geometry]) boxes_[geometry] = all_boxes(std::get<Mesh>(scene_.geometries[geometry].data));
        return boxes_[geometry];
    }

    /// Cells that a tree of this depth stores, without its leaves. Empty if a level has too many.
    std::optional<std::uint64_t> cells(std::uint32_t geometry, int depth)
    {
        std::vector<std::uint64_t>& levels = cells_[geometry];
        if (int(levels.size()) < depth) {
            levels.clear();
            try {
                const GrownTree tree(scene_.geometries.share(geometry), {.depth = depth}, depth - 1);
                for (int level = 0; level < depth; ++level) levels.push_back(tree.level(level).size());
            } catch (const Error&) {
                return std::nullopt;
            }
        }
        std::uint64_t sum = 0;
        for (int level = 0; level < depth; ++level) sum += levels[std::size_t(level)];
        return sum;
    }

private:
    const Scene& scene_;
    std::vector<std::uint64_t> boxes_;
    std::vector<std::vector<std::uint64_t>> cells_; ///< by geometry and level
};

/// Plays the workload again, without ageing if cells were dropped, and counts the trees' nodes at its end.
void count(StudyWorkload& workload, StudyRow& row, WholeModel& whole, const std::vector<std::uint8_t>& used)
{
    Settings settings = row.variant.settings;
    settings.age_limit = no_ageing;
    workload.move(0);
    Pipeline pipeline(workload.scene, settings);
    for (int frame = 0; frame < workload.frames(); ++frame) {
        workload.move(frame);
        row.nodes_needed = pipeline.step(workload.scene).trees.nodes;
    }
    const auto tree_of = [&](std::uint32_t g) {
        return WorldAccess::tree(pipeline.world(), pipeline.model(GeometryId{g}));
    };
    int deepest = settings.depth.value_or(1); // max_error: depth for trees that no test reached
    for (std::uint32_t g = 0; g < used.size(); ++g)
        if (const Ocst* tree = tree_of(g)) deepest = std::max(deepest, tree->depth());
    const bool exact = exact_level(settings) == ExactLevel::predicates;
    row.nodes_all = 0;
    for (std::uint32_t g = 0; g < used.size() && row.nodes_all; ++g) {
        if (!used[g]) continue;
        const bool mesh = std::holds_alternative<Mesh>(workload.scene.geometries[g].data);
        if (mesh && (exact || wants_obbs(settings))) *row.nodes_all += whole.boxes(g);
        if (mesh && wants_obbs(settings)) continue;
        const Ocst* tree = tree_of(g);
        const std::optional<std::uint64_t> cells = whole.cells(g, tree ? tree->depth() : deepest);
        cells ? void(*row.nodes_all += *cells) : row.nodes_all.reset();
    }
}

} // namespace

void count_needed(StudyWorkload& workload, Study& study)
{
    WholeModel whole(workload.scene);
    std::vector<std::uint8_t> used(workload.scene.geometries.size());
    for (GeometryId geometry : workload.scene.geometry) used[index(geometry)] = 1;
    Progress progress("counting needed nodes: variant", study.rows.size());
    for (StudyRow& row : study.rows) count(workload, row, whole, used), progress.step();
}

} // namespace oncollide::tools
