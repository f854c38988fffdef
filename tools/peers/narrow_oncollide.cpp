#include "narrow_peer.hpp"

#include <fmt/format.h>

#include "../tree_pair.hpp"

namespace oncollide::tools {
namespace {

using Promise = NarrowContender::Promise;

/// The walk of two sphere-trees. The trees grow as poses need them: only in the warm-up pass, as
/// every pose is met there.
class WalkPeer final : public NarrowPeer {
public:
    WalkPeer(const Mesh& a, const Mesh& b, const Settings& settings) : trees_(fill(scene_, a, b), settings) {}

    bool collides(const Eigen::Isometry3d& b) override { return trees_.walk(b).status != WalkStatus::separate; }
    void all_pairs(const Eigen::Isometry3d& b, std::vector<TrianglePair>& pairs) override
    {
        trees_.all_meeting(b, found_);
        pairs.clear();
        for (TriangleMeeting m : found_) pairs.push_back({m.a, m.b});
    }

private:
    static Scene& fill(Scene& scene, const Mesh& a, const Mesh& b)
    {
        scene.add_body({.name = "a", .geometry = scene.add("a", a)});
        scene.add_body({.name = "b", .geometry = scene.add("b", b)});
        return scene;
    }

    Scene scene_;
    TreePair trees_;
    std::vector<TriangleMeeting> found_;
};

NarrowContender walk(int depth)
{
    return {.name = fmt::format("walk-{}", depth),
            .what = fmt::format("oncollide sphere-trees, depth {}", depth),
            .group = Contender::Group::oncollide,
            .promise = Promise::conservative,
            .make = [depth](const Mesh& a, const Mesh& b) {
                Settings settings;
                settings.depth = depth;
                return std::make_unique<WalkPeer>(a, b, settings);
            }};
}

/// Exact predicates on the leaves of the trees, whose depth follows the number of triangles.
NarrowContender exact()
{
    return {.name = "exact",
            .what = "oncollide sphere-trees, tight, and exact predicates",
            .group = Contender::Group::oncollide,
            .promise = Promise::exact,
            .answers_all = true,
            .make = [](const Mesh& a, const Mesh& b) {
                Settings settings;
                settings.depth = 1;
                settings.exact = ExactLevel::predicates;
                return std::make_unique<WalkPeer>(a, b, settings);
            }};
}

} // namespace

void add_narrow_oncollide(std::vector<NarrowContender>& all)
{
    all.push_back(exact());
    for (int depth : {5, 6, 7, 8}) all.push_back(walk(depth));
}

} // namespace oncollide::tools
