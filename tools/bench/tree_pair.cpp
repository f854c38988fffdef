#include "bench/tree_pair.hpp"

#include <algorithm>

namespace oncollide::tools {

TreePair::TreePair(Scene& scene, const Settings& settings)
    : depth(settings.depth.value_or(6)), scene_(scene), forest_(scene, settings, make_cpu_backend())
{
}

WalkResult TreePair::walk(const Eigen::Isometry3d& b)
{
    scene_.poses[1] = b;
    const WalkPair pair = forest_.walk_pair(scene_, 0, 1);
    ParkedWork parked;
    Walker *walker = &walkers_[0], *last = &walkers_[1];
    walker->clear();
    WalkResult result = walker->start(pair, 0, forest_.backend(), parked);
    for (int round = 1; result.status == WalkStatus::parked; ++round) {
        requests_.clear();
        walker->requests(pair, parked, requests_);
        std::sort(requests_.begin(), requests_.end());
        requests_.erase(std::unique(requests_.begin(), requests_.end()), requests_.end());
        forest_.submit(requests_, 1);
        forest_.grow(0);
        std::swap(walker, last);
        walker->clear();
        result = walker->resume(pair, 0, forest_.backend(), *last, result, round, false, parked);
    }
    return result;
}

} // namespace oncollide::tools
