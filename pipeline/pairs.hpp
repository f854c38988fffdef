#pragma once
#include <ranges>
#include <span>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/scenes/rigid_motion.hpp>

namespace oncollide {

struct WorldImpl;

/// A model at a pose: a body that the World does not hold.
struct PlacedModel {
    ModelId model{};
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< rigid: model frame to world, metres
};

/// A model that moves: a body that the World does not hold.
struct MovingModel {
    ModelId model{};
    RigidMotion motion{};
};

/// Many models at poses as columns, as numerical programs hold them. A column of one entry serves all.
struct ModelColumns {
    std::span<const ModelId> models;
    std::span<const double> poses; ///< 16 numbers per entry: a rigid 4 x 4 matrix, row by row
};

using PairOfModels = PairOf<PlacedModel>;
using PairOfColumns = PairOf<ModelColumns>;

/// One side of a pair: a body of the World, or a model at a pose.
class PairSide {
public:
    PairSide(BodyId body) : body_(body) {}
    PairSide(const PlacedModel& placed) : placed_(&placed) {} ///< `placed` must outlive the call
    BodyId body() const { return body_; }
    const PlacedModel* placed() const { return placed_; } ///< null: a body

private:
    BodyId body_;
    const PlacedModel* placed_ = nullptr;
};

/// Many pairs: of bodies, of models at poses, or of models at poses as columns. The pairs must outlive the call.
class PairSpan {
public:
    template <std::ranges::contiguous_range Range>
    requires std::same_as<std::ranges::range_value_t<Range>, PairOfBodies> PairSpan(const Range& pairs)
        : pairs_(std::span<const PairOfBodies>(pairs))
    {
    }
    template <std::ranges::contiguous_range Range>
    requires std::same_as<std::ranges::range_value_t<Range>, PairOfModels> PairSpan(const Range& pairs)
        : pairs_(std::span<const PairOfModels>(pairs))
    {
    }
    PairSpan(const PairOfColumns& columns) : pairs_(columns) {}

    /// Calls work(pairs) with the pairs in the form that was given.
    template <class Work>
    decltype(auto) visit(Work work) const
    {
        return std::visit(work, pairs_);
    }

private:
    std::variant<std::span<const PairOfBodies>, std::span<const PairOfModels>, PairOfColumns> pairs_;
};

/// Queries of two sides, as the World is now. World::pairs() returns them. They can be copied freely and are valid as
/// long as the World. Layers, groups, exclusions and is_static do not matter here. All throw Error{usage} for ids that
/// are null, stale or of another World, Error{bad_data} for poses that are refused and, as Bodies::add(), for open
/// meshes.
///
/// One name serves one pair and many pairs: with two sides a query returns its result; with many pairs it writes their
/// results to its last argument, and throws Error{usage} if that has another length. Batches run on up to
/// Settings::threads threads; results do not depend on the number of threads or on the other pairs of the batch.
class ONCOLLIDE_API Pairs {
public:
    /// The verdict that step() would give the pair, with the settings' error, exactness, clearance and mode.
    Finding decide(PairSide a, PairSide b) const;
    void decide(PairSpan pairs, std::span<Finding> found) const;

    /// Certified bounds on the distance and the two nearest points. Solids that overlap (shapes, cells of maps, and
    /// closed meshes in solid mode) are 0 apart. Throws Error{usage} for options that are negative or NaN.
    Distance distance(PairSide a, PairSide b, const DistanceOptions& options = {}) const;
    void distance(PairSpan pairs, const DistanceOptions& options, std::span<Distance> found) const;

    /// All pairs of parts (triangles, cells, shapes) that meet; sorted by the parts, each once. Shapes and cells are
    /// solid, meshes are surfaces in every mode; a terrain counts with its stored heights. Cost: about a microsecond
    /// per contact.
    std::vector<Contact> contacts(PairSide a, PairSide b) const;
    void contacts(PairSpan pairs, Lists<Contact>& found) const; ///< overwrites `found`

    /// How deep the two penetrate each other: certified bounds for all kinds of bodies. Pairs without a depth say so in
    /// Penetration::supported. Cost: finding the contacts and a pass over all triangles of both; for other kinds, a
    /// decision, a pass over the vertices or the cells in the other's box, and up to some hundred distances.
    Penetration penetration(PairSide a, PairSide b) const;
    void penetration(PairSpan pairs, std::span<Penetration> found) const;

    /// When two moving models first meet, with the settings' clearance and mode; exact with all settings. Cost: 10 to
    /// 100 microseconds for meshes of 5,000 triangles. Throws Error{usage} for tolerances below 1e-12.
    SweepResult sweep(const MovingModel& a, const MovingModel& b, const SweepOptions& options = {}) const;
    void sweep(std::span<const PairOf<MovingModel>> pairs, const SweepOptions& options,
               std::span<SweepResult> found) const;

    /// Reduces the contacts to regions for a solver, with a normal, depths and few points each, and reports the loss.
    /// The result depends on the pair alone; with a and b swapped, it is the same with the normals reversed. Works for
    /// bodies of all kinds, except two half-spaces; closed meshes have an inside in every mode. Throws Error{usage} for
    /// options out of range. Cost: about 10 microseconds per contact, and 1 per triangle of the surfaces inside the
    /// other body.
    Manifold manifold(PairSide a, PairSide b, const ManifoldOptions& options = {}) const;
    void manifold(PairSpan pairs, const ManifoldOptions& options, ManifoldLists& found) const; ///< overwrites `found`

    /// All pairs of a vertex and a face, or of two edges, at most `dhat` (m, finite) apart, none lost; where the
    /// nearest point of a face or an edge is on its border, that edge or vertex counts instead. Each pair is listed
    /// once; pairs are sorted. Meshes, terrains, boxes and hulls; throws Error{usage} for other bodies. Features that
    /// meet are 0 apart.
    std::vector<NearFeatures> near_features(PairSide a, PairSide b, double dhat) const;
    void near_features(PairSpan pairs, double dhat, Lists<NearFeatures>& found) const; ///< overwrites `found`

    /// The largest error of the verdict `within` that the settings give a pair of the two: metres, above the clearance.
    double max_error(PairSide a, PairSide b) const;

private:
    friend class World;
    explicit Pairs(WorldImpl& world) : world_(&world) {}
    WorldImpl* world_;
};

} // namespace oncollide
