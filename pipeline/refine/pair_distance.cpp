#include <oncollide/pipeline/refine/pair_distance.hpp>

#include <oncollide/pipeline/refine/containment_test.hpp>
#include <oncollide/pipeline/refine/placed_pair.hpp>

namespace oncollide {

Distance PairDistance::find(const PairTask& task, Mode mode, double tolerance, double farthest)
{
    const Distance found = is_surface(*task.a) && is_surface(*task.b)
                               ? surfaces_.distance(*task.a, *task.pose_a, *task.b, *task.pose_b, tolerance, farthest)
                               : solids_.distance(task, tolerance, farthest);
    if (found.lower == 0 || without_walk(*task.a, *task.b)) return found; // which already treats shapes as solid
    const auto around = [&](const Model& model) {
        return model.shape() || (mode == Mode::solid && model.closed()) ? model.obb_tree() : nullptr;
    };
    if (const auto inside = one_holds_the_other(task, locator_, around))
        return {.lower = 0, .upper = 0, .point_a = *inside, .point_b = *inside};
    return found;
}

} // namespace oncollide
