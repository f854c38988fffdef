#include "narrow_peer.hpp"

#include <fmt/format.h>

#include "../tree_pair.hpp"

namespace oncollide::tools {
namespace {

using Promise = NarrowContender::Promise;

/// The walk of two sphere-trees down to one depth. The trees grow as poses need them: only in the warm-up pass, as
/// every pose is met there.
class WalkPeer final : public NarrowPeer {
public:
    WalkPeer(const Mesh& a, const Mesh& b, int depth) : trees_(fill(scene_, a, b), depth) {}

    bool collides(const Eigen::Isometry3d& b) override { return trees_.walk(b).status != WalkStatus::separate; }

private:
    static Scene& fill(Scene& scene, const Mesh& a, const Mesh& b)
    {
        scene.add_body({.name = "a", .geometry = scene.add("a", a)});
        scene.add_body({.name = "b", .geometry = scene.add("b", b)});
        return scene;
    }

    Scene scene_;
    TreePair trees_;
};

NarrowContender walk(int depth)
{
    return {.name = fmt::format("walk-{}", depth),
            .what = fmt::format("oncollide sphere-trees, depth {}", depth),
            .group = Contender::Group::oncollide,
            .promise = Promise::conservative,
            .make = [depth](const Mesh& a, const Mesh& b) { return std::make_unique<WalkPeer>(a, b, depth); }};
}

} // namespace

void add_narrow_oncollide(std::vector<NarrowContender>& all)
{
    for (int depth : {5, 6, 7, 8}) all.push_back(walk(depth));
}

} // namespace oncollide::tools
