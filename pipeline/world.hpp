#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/pipeline/settings.hpp>
#include <oncollide/scenes/model/mesh.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>
#include <oncollide/scenes/model/shape.hpp>
#include <oncollide/scenes/model/terrain.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide {

class CookedMesh;
struct Geometry;

/// A new body, for World::add_body().
struct BodySpec {
    ModelId model{};
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< rigid: body frame to world, metres
    bool is_static = false;           ///< two static bodies never form a pair; a static body may still be moved
    std::uint32_t layer = 1;          ///< bits: the layers that the body is on
    std::uint32_t mask = 0xffffffffu; ///< bits: the layers that the body collides with
    std::uint32_t group = 0;          ///< no two bodies of one group other than 0 form a pair. To keep only neighbours
                                      ///< apart, as the links of a robot, use World::exclude()
    std::uint64_t user = 0;           ///< yours: the World stores it and does not read it
};

/// Limits a query to the bodies that would form a pair with a body of this layer, mask and group.
struct QueryFilter {
    std::uint32_t layer = 1, mask = 0xffffffffu, group = 0;
};

/// A model at a pose: a body that the World does not hold.
struct PlacedModel {
    ModelId model{};
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< rigid: model frame to world, metres
};

/// A model at a pose, to be tested against the bodies of a World.
struct ModelQuery {
    ModelId model{};
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    QueryFilter filter{};
};

/// A model that moves: a body that the World does not hold.
struct MovingModel {
    ModelId model{};
    RigidMotion motion{};
};

/// Two models that move.
struct PairOfMovingModels {
    MovingModel a, b;
};

/// A body that a query could not rule out: its verdict is never separate.
struct QueryHit : Finding {
    BodyId body;
};

/// The hits of many queries: hits[offsets[i]] up to hits[offsets[i + 1]] belong to query i, sorted by the bodies'
/// slots.
struct QueryHits {
    std::vector<QueryHit> hits;
    std::vector<std::size_t> offsets; ///< one more than there are queries; the first is 0
};

/// A body near a model at a pose.
struct BodyDistance {
    BodyId body;
    Distance distance;
};

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

/// Two models at poses.
struct PairOfModels {
    PlacedModel a, b;
};

/// Many pairs of models at poses as columns, one entry per pair, as numerical programs hold them. A column of one entry
/// serves all pairs.
struct ModelPairColumns {
    std::span<const ModelId> a, b;
    std::span<const double> poses_a, poses_b; ///< 16 numbers per entry: a rigid 4 x 4 matrix, row by row
};

/// A candidate of a frame: two bodies that may collide, and whose AABBs are at most the clearance apart (unless the
/// broad phase is skipped).
struct CandidatePair {
    BodyId a, b;       ///< a.slot < b.slot
    Aabb box_a, box_b; ///< in the world, without the clearance
};

/// The choice of a filter for one candidate.
enum class PairChoice : std::uint8_t {
    refine,
    refine_swapped, ///< as the pair (b, a), in this order in the results; the last bits of a bound may depend on it
    drop,           ///< the pair is not in the results
};

/// Sets choices[i] for pairs[i]; each is `refine` before the call. A frame calls it for runs of at most 1,024
/// candidates, in the order of their slots. It may call const members of the World that return data of bodies, and no
/// others. It must not throw.
using PairFilter = std::function<void(std::span<const CandidatePair> pairs, std::span<PairChoice> choices)>;

/// A copy of the state and the counts of a World.
struct WorldInfo {
    std::size_t bodies = 0, models = 0;
    std::uint64_t frames = 0;       ///< steps so far
    std::size_t bytes = 0;          ///< held for bodies, boxes, trees and joined faces; the geometries come on top
    std::string backend;            ///< finds grey cells, e.g. "cpu (avx2)"
    std::string renderer;           ///< GL_RENDERER of a GPU backend; empty otherwise
    std::string backend_note;       ///< why the backend is not the expected one; empty: it is
    std::vector<StageStats> totals; ///< sums over all frames, per stage
    std::vector<DelimitedRegion> regions; ///< regions that the last frame's delimitation examined, level by level;
                                          ///< empty if it was skipped, or if bodies changed and a query took that in
    std::vector<std::string> file_faults; ///< one line per chunk of a cooked file that could not be read; pairs that
                                          ///< needed it are `undecided`
};

/// Bodies and their models, which come, go, move and change between frames; a World finds which of them collide.
///
///     World world({.max_error = 0.01});
///     const ModelId hill = world.add(load_mesh("hill.obj")), truck = world.add(load_mesh("truck.glb"));
///     world.add_body({.model = hill, .is_static = true});
///     const BodyId mine = world.add_body({.model = truck, .pose = start});
///     while (...) {
///         world.set_pose(mine, next);
///         for (const PairResult& pair : world.step().pairs) ...
///     }
///
/// The cost of a frame follows the bodies that changed and the pairs they are in; a pair at rest costs a copy of its
/// result. Nothing is precomputed: trees grow
/// where collisions reach. A warm step without additions allocates nothing.
///
/// Ids that are null, stale or of another World are errors. Errors are thrown at the call that brings them in, and then
/// nothing has changed: Error{usage} for such ids and for spans of different lengths, Error{bad_data} for poses that
/// are not rigid (R^T R off the identity by more than 1e-6, or a mirror), not finite or beyond 1e15 m, and for invalid
/// geometry. Every call on a World that was moved from throws Error{usage}, except destruction and assignment.
///
/// Const calls may run on many threads at once as long as no other call does. A World with a GPU backend belongs to the
/// thread that made it.
class ONCOLLIDE_API World {
public:
    /// Throws Error{usage} for settings out of range, Error{no_gpu} for a backend that cannot run here.
    explicit World(const Settings& settings = {});
    ~World();
    World(World&&) noexcept;
    World& operator=(World&&) noexcept;

    // --- Models. `name` is for messages. Throws Error{bad_data} that names the fault in a geometry.
    ModelId add(Mesh mesh, std::string name = {});
    ModelId add(Shape shape, std::string name = {});
    ModelId add(OccupancyMap map, std::string name = {});
    ModelId add(Terrain terrain, std::string name = {});
    ModelId add(std::shared_ptr<const CookedMesh> mesh, std::string name = {}); ///< read where tests need it
    ModelId add(std::shared_ptr<const Geometry> geometry);                      ///< shared, as with a Scene
    /// Gives the model another geometry, which all its bodies have from now on. Cost: O(bodies of the World).
    void replace(ModelId model, Mesh mesh);
    void replace(ModelId model, Shape shape);
    void replace(ModelId model, OccupancyMap map);
    void replace(ModelId model, Terrain terrain);
    void replace(ModelId model, std::shared_ptr<const Geometry> geometry);
    // Change cells of a map, as OccupancyMap's functions do, for all bodies of the model. Cost: of the change; the
    // first change also copies the map, 8 bytes per inner node. Sphere-trees of the map grow anew. Throws Error{usage}
    // for a model that is not a map.
    void set_cells(ModelId map, std::span<const Eigen::Vector3d> points, CellState state);
    void set_cells(ModelId map, const Aabb& box, CellState state);
    void replace_cells(ModelId map, const Aabb& box, const OccupancyMap& by);
    void insert_scan(ModelId map, std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& origin,
                     double max_range = -1);
    const OccupancyMap& map(ModelId map) const; ///< valid until the next change of the model
    /// Throws Error{usage} while a body uses it.
    void remove(ModelId model);
    bool contains(ModelId model) const;
    /// True for a mesh with an inside: every edge is shared by two triangles that run along it in opposite directions.
    /// Cost: of is_closed(), once.
    bool closed(ModelId model) const;
    /// The model in a slot. Null if the slot is free.
    ModelId model_at(std::uint32_t slot) const;
    std::size_t models() const; ///< their number

    // --- Bodies, one or many.
    /// In solid mode Error{bad_data} names a mesh that is not closed, and its open edges, at its first body.
    BodyId add_body(const BodySpec& body);
    void add_bodies(std::span<const BodySpec> bodies, std::span<BodyId> ids);
    void reserve_bodies(std::size_t bodies); ///< makes room for this number of bodies in all
    void remove_body(BodyId body);
    void remove_bodies(std::span<const BodyId> bodies); ///< each once
    bool contains(BodyId body) const;
    std::size_t size() const; ///< number of bodies

    void set_pose(BodyId body, const Eigen::Isometry3d& pose);
    void set_poses(std::span<const BodyId> bodies, std::span<const Eigen::Isometry3d> poses);
    /// Moves the body as set_pose() does, and lets the next step() report contacts on the way: from its pose so far to
    /// `to`, over the time from 0 to 1. The motion ends with that step. Until then queries may test a larger box than
    /// the body's.
    void set_motion(BodyId body, const Eigen::Isometry3d& to, MotionPath path = MotionPath::linear);
    void set_motions(std::span<const BodyId> bodies, std::span<const Eigen::Isometry3d> to,
                     MotionPath path = MotionPath::linear);
    /// The same along any motion; the body need not be at its first pose.
    void set_motion(BodyId body, const RigidMotion& motion);
    /// How closely step() brackets contacts of moving bodies. Throws Error{usage} for tolerances below 1e-12.
    void set_sweep_options(const SweepOptions& options);
    void set_static(BodyId body, bool is_static);
    /// Puts bodies to sleep. A pair of two bodies that are each asleep or static stays as it is: it is reported with
    /// its last result, begins and ends nothing, and is not tested, not even under a budget, which lets other pairs at
    /// rest be tested in every frame; only undecided pairs are. A change of its pose, filter or model wakes a body.
    void sleep(std::span<const BodyId> bodies);
    void sleep(BodyId body) { sleep({&body, 1}); }
    void wake(std::span<const BodyId> bodies);
    void wake(BodyId body) { wake({&body, 1}); }
    void set_layers(BodyId body, std::uint32_t layer, std::uint32_t mask);
    void set_group(BodyId body, std::uint32_t group);
    void set_model(BodyId body, ModelId model);
    void set_user(BodyId body, std::uint64_t user);
    /// The two never form a pair, until include() or until one of them is removed.
    void exclude(BodyId a, BodyId b);
    void include(BodyId a, BodyId b);

    const Eigen::Isometry3d& pose(BodyId body) const; ///< valid until the next change
    bool is_static(BodyId body) const;
    bool is_asleep(BodyId body) const;
    std::uint32_t layer(BodyId body) const;
    std::uint32_t mask(BodyId body) const;
    std::uint32_t group(BodyId body) const;
    ModelId model(BodyId body) const;
    std::uint64_t user(BodyId body) const;
    bool excluded(BodyId a, BodyId b) const;
    /// The body in a slot. Null if the slot is free.
    BodyId body_at(std::uint32_t slot) const;

    // --- Frames.
    /// Chooses which candidate pairs step() refines, where layers, groups and exclusions do not suffice; empty: all.
    /// Queries ignore it. Results are deterministic if the choice depends on the pair alone, not on the run that holds
    /// it. A pair that is dropped or swapped from some frame on ends in that frame. Cost: of the calls, besides about
    /// 0.1 microseconds per candidate.
    void set_pair_filter(PairFilter filter);
    /// Reports all pairs as the bodies are now. Throws Error{no_gpu} if a GPU backend that was requested by name was
    /// lost in the frame before. That frame is complete: the CPU finished it. The CPU takes over with backend `auto`.
    FrameView step();

    // --- Queries: one pair now. A side is a body or a model at a pose. Layers, groups, exclusions and is_static do not
    // matter here. Batches run on up to Settings::threads threads; results do not depend on the number of threads or on
    // the other pairs of the batch. All throw Error{usage} for spans of unequal lengths, as add_body() for open meshes.
    /// The verdict that step() would give the pair, with the settings' error, exactness, clearance and mode.
    Finding decide(PairSide a, PairSide b) const;
    void decide(std::span<const PairOfBodies> pairs, std::span<Finding> found) const;
    void decide(std::span<const PairOfModels> pairs, std::span<Finding> found) const;
    /// Decides verdicts.size() pairs. Throws Error{usage} for a column of another length that is not one
    /// entry; if a pair is refused, results of pairs before it may have been written.
    void decide(const ModelPairColumns& pairs, std::span<Verdict> verdicts, std::span<double> bounds) const;

    /// Sets near[i] to 0 for models that are certainly farther apart than the clearance and reaches[i] (m, >= 0), as
    /// bounding boxes show, and to 1 for others. Costs much less than distances. Surfaces alone count for meshes.
    void near(std::span<const PairOfModels> pairs, std::span<const double> reaches, std::span<std::uint8_t> near) const;

    /// Certified bounds on the distance, to `tolerance` (m, >= 0) besides rounding, and the two nearest points. If they
    /// are farther apart than `cutoff` (m), only a lower bound above it is found. Solids that overlap (shapes, cells of
    /// maps, and closed meshes in solid mode) are 0 apart. Throws Error{usage} for a tolerance or a cutoff that is
    /// negative or NaN.
    Distance distance(PairSide a, PairSide b, double tolerance = 0, double cutoff = no_cutoff) const;
    void distances(std::span<const PairOfBodies> pairs, std::span<Distance> found, double tolerance = 0,
                   double cutoff = no_cutoff) const;
    void distances(std::span<const PairOfModels> pairs, std::span<Distance> found, double tolerance = 0,
                   double cutoff = no_cutoff) const;
    void distances(const ModelPairColumns& pairs, std::span<Distance> found, double tolerance = 0,
                   double cutoff = no_cutoff) const;

    /// All pairs of parts (triangles, cells, shapes) that meet; sorted by the parts, each once. Shapes and cells are
    /// solid, meshes are surfaces in every mode; a terrain counts with its stored heights. Cost: about a microsecond
    /// per contact.
    std::vector<Contact> contacts(PairSide a, PairSide b) const;
    void contacts(std::span<const PairOfBodies> pairs, ContactLists& lists) const; ///< overwrites `lists`
    void contacts(std::span<const PairOfModels> pairs, ContactLists& lists) const; ///< overwrites `lists`

    /// How deep the two penetrate each other: certified bounds for all kinds of bodies. Pairs without a depth say so in
    /// Penetration::supported. Cost: of the contacts, and of a pass over all triangles of both; for other kinds of a
    /// decision, of a pass over the vertices or the cells in the other's box, and of up to some hundred distances.
    Penetration penetration(PairSide a, PairSide b) const;
    void penetration(std::span<const PairOfBodies> pairs, std::span<Penetration> found) const;
    void penetration(std::span<const PairOfModels> pairs, std::span<Penetration> found) const;

    /// When two moving models first meet, with the settings' clearance and mode; exact with all settings. Cost: 10 to
    /// 100 microseconds for meshes of 5,000 triangles. Throws Error{usage} for tolerances below 1e-12.
    SweepResult sweep(const MovingModel& a, const MovingModel& b, const SweepOptions& options = {}) const;
    void sweep(std::span<const PairOfMovingModels> pairs, std::span<SweepResult> found,
               const SweepOptions& options = {}) const;
    /// Sets until[i] to a lower bound of the time at which the models come within margins[i] (m, >= 0) more than the
    /// clearance of each other, if they are farther apart at time 0; 1: not before the end. Cost: of a step of sweep().
    void clear_until(std::span<const PairOfMovingModels> pairs, std::span<const double> margins,
                     std::span<double> until) const;
    /// Reduces the contacts to regions for a solver, with a normal, depths and few points each, and reports the loss.
    /// The result depends on the pair alone; with a and b swapped, it is the same with the normals reversed. For bodies
    /// of all kinds, except two half-spaces; closed meshes have an inside in every mode. Throws Error{usage} for
    /// options out of range. Cost: about 10 microseconds per contact, and 1 per triangle of the surfaces inside the
    /// other body.
    Manifold manifold(PairSide a, PairSide b, const ManifoldOptions& options = {}) const;
    void manifolds(std::span<const PairOfBodies> pairs, const ManifoldOptions& options,
                   ManifoldLists& lists) const; ///< overwrites `lists`
    /// All pairs of a vertex and a face, or of two edges, at most `dhat` (m, finite) apart, none lost; where the
    /// nearest point of a face or an edge is on its border, that edge or vertex counts instead. Each pair once, sorted.
    /// Meshes, terrains, boxes and hulls; throws Error{usage} for other bodies. Features that meet are 0 apart.
    void near_features(std::span<const PairOfBodies> pairs, double dhat,
                       NearFeatureLists& lists) const; ///< overwrites `lists`

    // --- Queries: one thing against all bodies. step() gives the same results for a body of that geometry and pose,
    // except that segments are exact.
    // Cost: of the pairs that boxes cannot rule out. For contacts and penetration, pass a hit's body as the other side
    // to the functions above. Batches overwrite `hits` and run on up to Settings::threads threads.
    std::vector<QueryHit> query(ModelId model, const Eigen::Isometry3d& pose, const QueryFilter& filter = {}) const;
    void query(std::span<const ModelQuery> queries, QueryHits& hits) const;
    /// The bodies that near() sets to 1 with model i and reaches[i]: `undecided`, without a bound.
    void near(std::span<const ModelQuery> queries, std::span<const double> reaches, QueryHits& hits) const;
    /// Bodies that a segment touches, sorted by slots. For meshes, terrains, maps, boxes and hulls the results are
    /// exact with all settings, for the segment's points moved into the body's frame in double. Round shapes,
    /// half-spaces, a clearance, contact_kinds and ignore_touching have the errors of step(). Cost: 1 to 10
    /// microseconds for each body whose AABB the segment meets.
    std::vector<QueryHit> query(const Segment& segment, const QueryFilter& filter = {}) const;
    void query(std::span<const Segment> segments, const QueryFilter& filter, QueryHits& hits) const;
    /// The first body that a segment hits, and where; nothing if it hits none. A body is hit where query() of the
    /// segment finds it with exact results; clearance, contact_kinds and ignore_touching have no effect. Where several
    /// bodies may be first, their smallest slot is returned, and then the smallest part; certain hits come before
    /// others. The bounds of the fraction then enclose the first point in any of these bodies. Cost: like the cost of
    /// query() for the bodies in front of the hit; 3 to 20 microseconds for a round shape.
    /// Throws Error{bad_data} for a segment without length, not finite or beyond 1e15 m.
    std::optional<CastHit> cast(const Segment& segment, const QueryFilter& filter = {}) const;
    /// Sets hits[i] for segments[i]. Runs on up to Settings::threads threads.
    void cast(std::span<const Segment> segments, const QueryFilter& filter, std::span<CastHit> hits) const;
    /// The first point in each body that the segment hits, sorted by lower bounds of the fractions, then by slots.
    std::vector<CastHit> cast_all(const Segment& segment, const QueryFilter& filter = {}) const;
    /// The first contact of a moving model with the bodies at their poses. Without contact the body is null and the
    /// verdict `separate`. clear_until is certified for all bodies: for a planner, the last valid time of an edge. If a
    /// pair stays undecided before the first certain contact, its verdict and its body are returned.
    SweepHit cast(const MovingModel& model, const QueryFilter& filter = {}, const SweepOptions& options = {}) const;
    /// Sets hits[i] for models[i]. Runs on up to Settings::threads threads.
    void cast(std::span<const MovingModel> models, const QueryFilter& filter, std::span<SweepHit> hits,
              const SweepOptions& options = {}) const;
    /// The first contact with each body, sorted by clear_until, then by slots.
    std::vector<SweepHit> cast_all(const MovingModel& model, const QueryFilter& filter = {},
                                   const SweepOptions& options = {}) const;
    /// Bodies that a solid box of the world touches or contains.
    std::vector<QueryHit> query(const Aabb& box, const QueryFilter& filter = {}) const;
    /// Bodies at most `cutoff` (m, finite) away from a model at a pose, as distance() measures them, sorted by slots.
    std::vector<BodyDistance> distances(const ModelQuery& query, double cutoff, double tolerance = 0) const;

    /// The AABB of a model at a pose, or on its whole way, as step() computes it for a body. Not const: may prepare
    /// data for more such boxes.
    Aabb bounds(ModelId model, const Eigen::Isometry3d& pose);
    Aabb bounds(ModelId model, const RigidMotion& motion);

    /// The largest error of the verdict `within` that the settings give a pair of the two: metres, above the clearance.
    double max_error(BodyId a, BodyId b) const;

    // --- About the World.
    const Settings& settings() const;                  ///< with `exact` resolved, see exact_level()
    static std::span<const std::string_view> stages(); ///< names in order: bounds, delimitation, broad, refine, exact
    /// Chained hash of all frames so far: equal input gives an equal hash for any thread count and instruction set.
    std::uint64_t hash() const;
    /// Makes the next step frame `frame`. `hash` is the hash of the frames before it, which another World stepped.
    void continue_from(std::uint32_t frame, std::uint64_t hash);
    /// Everything else that can be known of it. Cost: of the copies.
    WorldInfo inspect() const;

    static constexpr double no_cutoff = std::numeric_limits<double>::infinity();

private:
    friend struct WorldAccess; // for the library's own tools and tests; not installed
    struct ONCOLLIDE_LOCAL Impl;
    explicit World(std::unique_ptr<Impl> impl);
    Impl& impl() const;
    std::unique_ptr<Impl> impl_;
};

} // namespace oncollide
