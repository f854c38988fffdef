#include "peers/narrow/tree_pair.hpp"

namespace oncollide::tools {

namespace {

Settings with_depth(Settings settings, int depth)
{
    settings.depth = depth, settings.max_error.reset();
    return settings;
}

} // namespace

TreePair::TreePair(const Scene& scene, const Settings& settings)
    : depth(settings.depth.value_or(6)), settings_(with_depth(settings, depth)), models_(settings_, make_cpu_backend()),
      a_(models_[models_.add(scene.geometries.share(index(scene.geometry[0])))]),
      b_(models_[models_.add(scene.geometries.share(index(scene.geometry[1])))]), pose_a_(scene.poses[0]),
      refiner_(models_), context_{.settings = settings_, .trees = {}, .rounds = {}, .began = {}}
{
    for (Model* model : {&a_, &b_}) models_.spheres(*model, models_.max_error(a_, b_));
}

Finding TreePair::walk(const Eigen::Isometry3d& b)
{
    const PairTask task{0, &a_, &b_, &pose_a_, &b};
    Finding answer{};
    context_.rounds.clear();
    refiner_.refine(context_, {&task, 1}, nullptr, {&answer, 1});
    return answer;
}

} // namespace oncollide::tools
