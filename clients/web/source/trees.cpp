// The spheres that a model's tree has now, to be drawn.
#include "call.hpp"
#include "world.hpp"

#include <oncollide/pipeline/world/world_access.hpp>

using namespace oncollide;
using namespace oncollide::web;

/// Centre, radius and level of the cells at which the tree ends, in the model's frame; none before tests have reached
/// it.
ONCOLLIDE_WEB int oc_models_spheres(const HeldWorld* held, double model)
{
    return call([=] {
        const Ocst* const tree = WorldAccess::tree(held->world, held->model(model));
        std::vector<CellKey> ends;
        if (tree)
            tree->for_each_cell([&](CellKey cell, bool expanded) {
                if (!expanded) ends.push_back(cell);
            });
        ColumnWriter rows(results(), ends.size(), 5);
        for (std::size_t i = 0; i < ends.size(); ++i) {
            const int level = level_of(ends[i]);
            rows.next(i, tree->centre(ends[i])), rows.next(i, tree->radius(level)), rows.next(i, level);
            rows.end_row();
        }
    });
}
