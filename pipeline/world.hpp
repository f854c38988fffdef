#pragma once
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/pipeline/contacts.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/pipeline/settings.hpp>
#include <oncollide/scenes/ids.hpp>
#include <oncollide/scenes/model/mesh.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>
#include <oncollide/scenes/model/shape.hpp>
#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide {

class CookedMesh;
struct Geometry;
class Ocst;
class OcclusionBackend;

/// What add_body() needs to know of a body.
struct BodySpec {
    ModelId model{};
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< rigid: body frame to world, metres
    bool is_static = false;               ///< two static bodies never form a pair; a static body may still be moved
    std::uint32_t layer = 1;          ///< bits: the layers that the body is on
    std::uint32_t mask = 0xffffffffu; ///< bits: the layers that the body collides with
    std::uint32_t group = 0;          ///< bodies of one group other than 0 never collide: the links of one robot
    std::uint64_t user = 0;           ///< yours: World keeps it and makes nothing of it
};

/// Which bodies a query may hit: as if what is queried were a body with this layer, mask and group.
struct QueryFilter {
    std::uint32_t layer = 1, mask = 0xffffffffu, group = 0;
};

/// A model at a pose, to be tested against the bodies of a World.
struct ModelQuery {
    ModelId model;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    QueryFilter filter{};
};

/// A body that a query could not rule out.
struct QueryHit {
    BodyId body;
    Verdict verdict; ///< never separate
    ContactKind kind;
    double bound; ///< as PairResult::bound
};

/// Those of many queries, one after the other, each query's sorted by the bodies' slots.
struct QueryHits {
    std::vector<QueryHit> hits;
    std::vector<std::size_t> ends; ///< by query: where its hits end, and the next one's begin
};

/// Two points in the world, metres.
struct Segment {
    Eigen::Vector3d from, to;
};

/// Bodies and their models, which come, go, move and change between frames, and which of them collide.
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
/// A change costs what it changes; a body that rests costs nothing. Nothing is precomputed: trees grow where collisions
/// reach. A warm step without additions allocates nothing.
///
/// Ids carry a generation: the id of what was removed is stale, and using it is an error, not another body.
/// Errors are thrown at the call that brings them in, and then nothing has changed: Error{usage} for stale or unknown
/// ids and spans of different lengths, Error{bad_data} for poses that are not rigid (R^T R off the identity by more
/// than 1e-6, or a mirror), not finite or beyond 1e15 m, and for geometry that is not valid.
///
/// Const calls may run on many threads at once as long as no other call does. With a GPU backend a World belongs to the
/// thread that made it.
class World {
public:
    /// Throws Error{usage} for settings out of range, Error{no_gpu} for a backend that cannot run here.
    explicit World(const Settings& settings = {});
    World(const Settings& settings, std::unique_ptr<OcclusionBackend> backend); ///< in place of settings.backend
    ~World();
    World(World&&) noexcept;
    World& operator=(World&&) noexcept;

    // --- Models. `name` is for messages. Throws Error{bad_data} naming what is wrong with a geometry.
    ModelId add(Mesh mesh, std::string name = {});
    ModelId add(Shape shape, std::string name = {});
    ModelId add(OccupancyMap map, std::string name = {});
    ModelId add(Terrain terrain, std::string name = {});
    ModelId add(std::shared_ptr<const CookedMesh> mesh, std::string name = {}); ///< read where tests need it
    ModelId add(std::shared_ptr<const Geometry> geometry);                      ///< shares what a Scene holds
    /// Gives the model another geometry; all its bodies have it from now on. Cost: O(bodies of the World).
    void replace(ModelId model, Mesh mesh);
    void replace(ModelId model, Shape shape);
    void replace(ModelId model, OccupancyMap map);
    void replace(ModelId model, Terrain terrain);
    void replace(ModelId model, std::shared_ptr<const Geometry> geometry);
    // Changes of a map's cells, as OccupancyMap's functions make them; all bodies of the model have them from now on.
    // Cost: of the change; at the first one also of a copy of the map, 8 bytes an inner node. Sphere-trees of the map
    // are grown anew. Throws Error{usage} for what is no map, too.
    void set_cells(ModelId map, std::span<const Eigen::Vector3d> points, CellState state);
    void set_cells(ModelId map, const Aabb& box, CellState state);
    void replace_cells(ModelId map, const Aabb& box, const OccupancyMap& by);
    void insert_scan(ModelId map, std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& origin,
                     double max_range = -1);
    const OccupancyMap& map(ModelId map) const; ///< valid until the next change of the model
    /// Throws Error{usage} while a body uses it.
    void remove(ModelId model);
    bool contains(ModelId model) const;
    /// Is the model a mesh in which every edge is shared by two triangles that run along it in opposite directions: has
    /// it an inside? Cost: that of is_closed(), once.
    bool closed(ModelId model) const;
    std::size_t models() const; ///< how many there are

    // --- Bodies, one or many.
    /// In solid mode Error{bad_data} names a mesh that is not closed, and its open edges, at its first body.
    BodyId add_body(const BodySpec& body);
    void add_bodies(std::span<const BodySpec> bodies, std::span<BodyId> ids);
    void reserve_bodies(std::size_t bodies); ///< makes room for so many in all
    void remove_body(BodyId body);
    void remove_bodies(std::span<const BodyId> bodies); ///< each once
    bool contains(BodyId body) const;
    std::size_t size() const; ///< how many there are

    void set_pose(BodyId body, const Eigen::Isometry3d& pose);
    void set_poses(std::span<const BodyId> bodies, std::span<const Eigen::Isometry3d> poses);
    void set_static(BodyId body, bool is_static);
    void set_layers(BodyId body, std::uint32_t layer, std::uint32_t mask);
    void set_group(BodyId body, std::uint32_t group);
    void set_model(BodyId body, ModelId model);
    void set_user(BodyId body, std::uint64_t user);
    /// These two never form a pair, until include() or until one is removed.
    void exclude(BodyId a, BodyId b);
    void include(BodyId a, BodyId b);

    const Eigen::Isometry3d& pose(BodyId body) const; ///< valid until the next change
    ModelId model(BodyId body) const;
    std::uint64_t user(BodyId body) const;
    bool is_static(BodyId body) const;
    /// The body in a slot; slots are used again. Nothing if it is free.
    std::optional<BodyId> body_at(std::uint32_t slot) const;

    // --- Frames.
    /// All pairs as the bodies are now. Throws Error{no_gpu} if a GPU backend that was requested by name was lost in
    /// the frame before. That frame is whole: the CPU finished it. Under `auto` it goes on.
    FrameView step();

    // --- Queries, which add no body: of the bodies as they are now, with the settings' error, exactness and clearance.
    // Each gives what step() would give a body of that geometry and pose. Cost: of the pairs that boxes cannot rule
    // out.
    std::vector<QueryHit> query(ModelId model, const Eigen::Isometry3d& pose, const QueryFilter& filter = {}) const;
    /// Many at once; on up to Settings::threads threads. Overwrites `hits`.
    void query(std::span<const ModelQuery> queries, QueryHits& hits) const;
    /// What a segment touches.
    std::vector<QueryHit> query(const Segment& segment, const QueryFilter& filter = {}) const;
    /// What reaches into a box of the world. The box is solid: bodies wholly inside are colliding, too.
    std::vector<QueryHit> query(const Aabb& box, const QueryFilter& filter = {}) const;

    /// The largest error of the verdict `within` that the settings give a pair of the two: metres, above the clearance.
    double max_error(BodyId a, BodyId b) const;

    /// All pairs of parts (triangles, cells, shapes) that meet, of two bodies of any kind, as they are now; sorted by
    /// the parts, none twice. Shapes and cells are solid, meshes are surfaces in every mode; of a terrain whose heights
    /// are off it is those stored that count. Cost: about a microsecond for each contact.
    std::vector<Contact> contacts(BodyId a, BodyId b) const;
    /// The same for many pairs, on up to Settings::threads threads. Overwrites `lists`.
    void contacts(std::span<const PairOfBodies> pairs, ContactLists& lists) const;
    /// How far pairs of bodies reach into each other, on up to Settings::threads threads: found[i] of pairs[i]. Throws
    /// Error{usage} for spans of different lengths and for a body without triangles: a round shape, a map, a terrain.
    /// Cost: of the contacts, and of a look at all triangles of both.
    void penetration(std::span<const PairOfBodies> pairs, std::span<Penetration> found) const;
    /// Certified bounds on the distance of two bodies of any kind, to `tolerance` (m, >= 0) besides rounding, and the
    /// two nearest points. Bodies farther apart than `farthest` get only a lower bound above that. Solids that overlap
    /// (shapes, cells of maps, and closed meshes in solid mode) are 0 apart. Throws Error{usage} for a tolerance or a
    /// limit that is negative or no number.
    Distance distance(BodyId a, BodyId b, double tolerance = 0,
                      double farthest = std::numeric_limits<double>::infinity()) const;

    // --- About the World.
    const Settings& settings() const;
    std::span<const std::string_view> stages() const; ///< names in order: bounds, delimitation, broad, ocst, exact
    std::span<const StageStats> totals() const;       ///< sums over all frames so far
    /// The regions that the last frame's delimitation looked at, level by level: empty where it was skipped, and once
    /// bodies changed and a query has taken that in.
    std::vector<DelimitedRegion> regions() const;
    /// Chained hash of all frames so far: equal input gives equal hash for any thread count and instruction set.
    std::uint64_t hash() const;
    /// The next step is frame `frame`, and `hash` that of all frames before it, which another World stepped.
    void continue_from(std::uint32_t frame, std::uint64_t hash);
    std::string backend() const;      ///< what finds grey cells, e.g. "cpu (avx2)"
    std::string renderer() const;     ///< GL_RENDERER of a GPU backend; empty otherwise
    std::string backend_note() const; ///< why it is not what one might expect; empty: nothing to say
    /// What went wrong with cooked files so far, a line for each chunk: what the pairs that needed it stay undecided
    /// for.
    std::vector<std::string> file_faults() const;
    std::size_t bytes() const; ///< held for bodies, boxes and trees; the geometries come on top
    /// The sphere-tree of a model as it is now, to look at. Null until a test reaches it. Valid until the next step.
    const Ocst* tree(ModelId model) const;

private:
    friend class RankWorld; // one process's share of a scene
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace oncollide
