#include "peers/narrow/narrow_peer.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include <oncollide/narrowphase/walks/traversal.hpp>

#include "fcl/fcl_pair.hpp"
#include "peers/narrow/tree_pair.hpp"

namespace oncollide::tools {
namespace {

/// Traversal of two sphere-trees. The trees grow only in the warm-up pass, because it runs every pose.
class SpheresPeer final : public NarrowPeer {
public:
    SpheresPeer(const Mesh& a, const Mesh& b, const Settings& settings, bool then_fcl)
        : trees_(fill(scene_, a, b), settings)
    {
        if (then_fcl) fcl_.emplace(a, b, FclNodes::obb);
    }

    bool collides(const Eigen::Isometry3d& b) override
    {
        const Finding found = trees_.walk(b);
        ++queries_;
        if (found.verdict == Verdict::within) bound_ = std::max(bound_, found.bound);
        return found.verdict != Verdict::separate && (!fcl_ || fcl_->collides(b));
    }
    std::string figures() const override
    {
        const double diagonal = bounds_of(scene_.geometries[0]).diagonal();
        return fmt::format(
            "largest bound {:.6f} m, {:.2f} % of the diagonal; {:.1f} pairs of cells per query; {} cells", bound_,
            100 * bound_ / diagonal, double(trees_.cell_pairs()) / double(std::max<std::uint64_t>(queries_, 1)),
            trees_.models().nodes());
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
    std::optional<FclPair> fcl_;
    double bound_ = 0;
    std::uint64_t queries_ = 0;
};

/// Traversal of two OBB trees, which grow in the same way.
class BoxesPeer : public NarrowPeer {
public:
    BoxesPeer(const Mesh& a, const Mesh& b) : a_(a), b_(b) {}

    bool collides(const Eigen::Isometry3d& b) override { return walk_.first_meeting(a_, b_, at(b)).pair.has_value(); }
    void all_pairs(const Eigen::Isometry3d& b, std::vector<TrianglePair>& pairs) override
    {
        walk_.all_meeting(a_, b_, at(b), found_);
        pairs.clear();
        for (const oncollide::TrianglePair& m : found_) pairs.push_back({m.a, m.b});
    }
    double distance(const Eigen::Isometry3d& b) override { return walk_.distance(a_, b_, at(b), 0).upper; }

protected:
    static RelativePose at(const Eigen::Isometry3d& b) { return {Eigen::Isometry3d::Identity(), b}; }

    ObbTree a_, b_;
    Traversal walk_;

private:
    std::vector<oncollide::TrianglePair> found_;
};

NarrowContender exact()
{
    return {.name = "exact",
            .what = "oncollide oriented boxes, exact predicates",
            .group = Group::oncollide,
            .promise = Promise::exact,
            .has_all_pairs = true,
            .has_distance = true,
            .make = [](const Mesh& a, const Mesh& b) { return std::make_unique<BoxesPeer>(a, b); }};
}

/// Its error is relative to the size of the larger mesh, the diagonal of its AABB.
class NearPeer final : public BoxesPeer {
public:
    NearPeer(const Mesh& a, const Mesh& b, double error)
        : BoxesPeer(a, b), error_(error * std::max(a.bounds.diagonal(), b.bounds.diagonal()))
    {
    }
    bool collides(const Eigen::Isometry3d& b) override { return walk_.near(a_, b_, at(b), 0, error_).near; }

private:
    double error_;
};

NarrowContender near(double error)
{
    return {.name = fmt::format("near-{}%", 100 * error),
            .what = fmt::format("oncollide oriented boxes, error {} % of size", 100 * error),
            .group = Group::oncollide,
            .promise = Promise::conservative,
            .make = [error](const Mesh& a, const Mesh& b) { return std::make_unique<NearPeer>(a, b, error); }};
}

} // namespace

NarrowContender sphere_walk(int depth, bool then_fcl)
{
    return {.name = fmt::format("walk-{}{}", depth, then_fcl ? "+fcl" : ""),
            .what = fmt::format("oncollide sphere-trees, depth {}{}", depth, then_fcl ? ", then FCL" : ""),
            .group = Group::oncollide,
            .promise = Promise::conservative,
            .make = [=](const Mesh& a, const Mesh& b) {
                return std::make_unique<SpheresPeer>(a, b, Settings{.depth = depth}, then_fcl);
            }};
}

void add_narrow_oncollide(std::vector<NarrowContender>& all)
{
    all.push_back(exact());
    for (double error : {0.001, 0.01}) all.push_back(near(error));
    for (int depth : {5, 6, 7, 8}) all.push_back(sphere_walk(depth, false));
}

} // namespace oncollide::tools
