#include "bench/tree_pair.hpp"

namespace oncollide::tools {

TreePair::TreePair(const Scene& scene, const Settings& settings)
    : depth(settings.depth.value_or(6)), settings_(settings), models_(settings_, make_cpu_backend()),
      a_(models_[models_.add(scene.geometries.share(index(scene.geometry[0])))]),
      b_(models_[models_.add(scene.geometries.share(index(scene.geometry[1])))]), pose_a_(scene.poses[0]),
      refiner_(models_), context_{.settings = settings_, .trees = {}, .rounds = {}, .began = {}}
{
    for (Model* model : {&a_, &b_}) models_.spheres(*model);
}

RefineResult TreePair::walk(const Eigen::Isometry3d& b)
{
    const PairTask task{0, &a_, &b_, &pose_a_, &b};
    RefineResult answer{};
    context_.rounds.clear();
    refiner_.refine(context_, {&task, 1}, nullptr, {&answer, 1});
    return answer;
}

} // namespace oncollide::tools
