#include "peers/peers.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <oncollide/narrowphase/walks/traversal.hpp>
#include <oncollide/pipeline/refine/sphere_refiner.hpp>

#include "fcl/fcl_pair.hpp"

namespace oncollide::tools {
namespace {

/// The library's own broad phase; it receives the list of moved boxes.
class OwnPeer final : public BroadPeer {
public:
    OwnPeer(std::unique_ptr<BroadPhase> broad, bool whole) : broad_(std::move(broad)), whole_(whole) {}

    void start(const BoxFrame& frame) override
    {
        std::vector<std::uint32_t> resting, moving;
        for (std::uint32_t body = 0; body < frame.boxes.size(); ++body)
            (frame.is_static[body] ? resting : moving).push_back(body);
        broad_->add(resting, true), broad_->add(moving);
    }

    void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) override
    {
        broad_->move(frame.moved);
        const std::span<const BodyPair> found = broad_->find_pairs({.boxes = frame.boxes}, whole_);
        pairs.assign(found.begin(), found.end());
    }

    BroadPhase* delimited() override { return whole_ ? nullptr : broad_.get(); }

private:
    std::unique_ptr<BroadPhase> broad_;
    bool whole_; ///< search all boxes, not only moved ones
};

/// Traversal of two sphere-trees with the refiner of the pipeline's stage. Only the trees are kept from one query to
/// the next; they grow only in the warm-up pass, because it runs every pose.
class SpheresPeer final : public NarrowPeer {
public:
    SpheresPeer(const Mesh& a, const Mesh& b, int depth, bool then_fcl)
        : settings_{.depth = depth}, models_(settings_, make_cpu_backend()), a_(add(a)), b_(add(b)),
          refiner_(models_), context_{.settings = settings_, .trees = {}, .rounds = {}, .began = {}},
          diagonal_(a.bounds.diagonal())
    {
        for (Model* model : {&a_, &b_}) models_.spheres(*model, models_.max_error(a_, b_));
        if (then_fcl) fcl_.emplace(a, b, FclNodes::obb);
    }

    bool collides(const Eigen::Isometry3d& b) override
    {
        const PairTask task{0, &a_, &b_, &pose_a_, &b};
        Finding found{};
        context_.rounds.clear();
        refiner_.refine(context_, {&task, 1}, nullptr, {&found, 1});
        ++queries_;
        if (found.verdict == Verdict::within) bound_ = std::max(bound_, found.bound);
        return found.verdict != Verdict::separate && (!fcl_ || fcl_->collides(b));
    }
    std::string figures() const override
    {
        return fmt::format(
            "largest bound {:.6f} m, {:.2f} % of the diagonal; {:.1f} pairs of cells per query; {} cells", bound_,
            100 * bound_ / diagonal_, double(context_.trees.node_pairs) / double(std::max<std::uint64_t>(queries_, 1)),
            models_.nodes());
    }

private:
    Model& add(const Mesh& mesh)
    {
        return models_[models_.add(std::make_shared<const Geometry>(Geometry{{}, mesh, {}}))];
    }

    const Settings settings_;
    ModelStore models_;
    Model &a_, &b_;
    const Eigen::Isometry3d pose_a_ = Eigen::Isometry3d::Identity();
    SphereRefiner refiner_;
    RefineContext context_;
    std::optional<FclPair> fcl_;
    double diagonal_, bound_ = 0;
    std::uint64_t queries_ = 0;
};

/// Traversal of two OBB trees, which grow in the same way.
class BoxesPeer : public NarrowPeer {
public:
    BoxesPeer(const Mesh& a, const Mesh& b) : a_(a), b_(b) {}

    bool collides(const Eigen::Isometry3d& b) override { return walk_.first_meeting(a_, b_, at(b)).pair.has_value(); }
    void all_pairs(const Eigen::Isometry3d& b, std::vector<TrianglePair>& pairs) override
    {
        walk_.all_meeting(a_, b_, at(b), pairs);
    }
    double distance(const Eigen::Isometry3d& b) override { return walk_.distance(a_, b_, at(b), 0).upper; }

protected:
    static RelativePose at(const Eigen::Isometry3d& b) { return {Eigen::Isometry3d::Identity(), b}; }

    ObbTree a_, b_;
    Traversal walk_;
};

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

} // namespace

NarrowContender sphere_walk(int depth, bool then_fcl)
{
    return {.name = fmt::format("walk-{}{}", depth, then_fcl ? "+fcl" : ""),
            .what = fmt::format("oncollide sphere-trees, depth {}{}", depth, then_fcl ? ", then FCL" : ""),
            .group = Group::oncollide,
            .promise = Promise::conservative,
            .make = maker<SpheresPeer>(depth, then_fcl)};
}

void add_oncollide(Contenders& all)
{
    const auto add_broad = [&](const char* name, const char* what,
                               std::unique_ptr<BroadPhase> (*make)(const BroadPhase::Options&), bool whole) {
        all.broad.all.push_back(
            {.name = name, .what = what, .group = Group::oncollide, .threaded = true, .make = [=](int threads) {
                 return std::make_unique<OwnPeer>(make({.threads = threads}), whole);
             }});
    };
    add_broad("kd", "oncollide kd-tree", make_kd_tree, true);
    add_broad("octree", "oncollide octree", make_octree, true);
    add_broad("dynamic", "oncollide kd-tree, delimited", make_kd_tree, false);
    all.narrow.all.push_back({.name = "exact",
                              .what = "oncollide oriented boxes, exact predicates",
                              .group = Group::oncollide,
                              .has_all_pairs = true,
                              .has_distance = true,
                              .make = maker<BoxesPeer>()});
    for (const double error : {0.001, 0.01})
        all.narrow.all.push_back({.name = fmt::format("near-{}%", 100 * error),
                                  .what = fmt::format("oncollide oriented boxes, error {} % of size", 100 * error),
                                  .group = Group::oncollide,
                                  .promise = Promise::conservative,
                                  .make = maker<NearPeer>(error)});
    for (const int depth : {5, 6, 7, 8}) all.narrow.all.push_back(sphere_walk(depth, false));
}

} // namespace oncollide::tools
