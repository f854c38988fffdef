#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/scenes/geometry.hpp>
#include <oncollide/scenes/rigid_motion.hpp>

namespace oncollide {

struct WorldImpl;

/// The models of a World: geometries that bodies share. World::models() returns them. Errors, threads and ids as
/// World's.
class ONCOLLIDE_API Models {
public:
    Models(const Models&) = delete;
    Models& operator=(const Models&) = delete;

    /// @param geometry  a Mesh, a Shape (Sphere, Box, ...), an OccupancyMap, a Terrain, or a mesh in a cooked file,
    ///                  which is read where tests need it
    /// @param name      for messages
    /// Throws Error{bad_data} that names the fault in a geometry.
    ModelId add(GeometryData geometry, std::string name = {});
    ModelId add(std::shared_ptr<const Geometry> geometry); ///< shared, as with a Scene
    /// Gives the model another geometry, which all its bodies have from now on; it keeps its name. Cost: O(bodies of
    /// the World).
    void replace(ModelId model, GeometryData geometry);
    void replace(ModelId model, std::shared_ptr<const Geometry> geometry);
    /// Gives the vertices of a mesh new positions, for all bodies of the model; the triangles stay. The World copies
    /// the positions. Results are as in a World that had this mesh from the beginning; only verdicts with an error
    /// allowed
    /// (`max_error`, `clearance`) may differ within that error, and bounds within rounding.
    ///
    /// Cost: about two copies of the positions, O(bodies of the World), and an is_closed() in solid mode. OBB trees
    /// stay: the nodes that tests reach are fitted anew. Sphere-trees and the neighbours of triangles are found anew
    /// when they are needed. The first call also copies the mesh and drops its trees. Geometry::recipe becomes empty.
    ///
    /// Throws Error{usage} for a model that is not a mesh in memory, or another number of positions, and
    /// Error{bad_data} that names a vertex that is not finite or farther than 1e15 m from the origin, or, in solid
    /// mode, the edge at which a mesh with bodies would open.
    ///
    ///     world.models().set_vertices(cloth, positions);
    ///     world.step();
    void set_vertices(ModelId model, std::span<const Eigen::Vector3d> positions);
    /// The same for vertices first, first + 1, ... Trees are fitted anew only where these vertices are.
    void set_vertices(ModelId model, std::size_t first, std::span<const Eigen::Vector3d> positions);
    /// Gives heights of a terrain new values, for all bodies of the model. The World copies them. Results are as in a
    /// World that had this terrain from the beginning, with the exceptions of set_vertices().
    ///
    /// Cost: about 20 ns per height, and O(bodies of the World). The tree stays: the parts over these heights are found
    /// anew at once. The first call also copies the terrain, which has 8 bytes per height from then on, and drops its
    /// tree. Geometry::recipe becomes empty.
    ///
    /// @param where    the columns and rows of the heights
    /// @param heights  row by row, where.columns * where.rows, metres. NaN and Terrain::no_data() are holes, if the
    ///                 terrain was made with no_data
    /// Throws Error{usage} for a model that is not a terrain in memory, a rectangle that is not part of it, or another
    /// number of heights, and Error{bad_data} that names a height that make_terrain() would refuse, or if no cell would
    /// be left.
    ///
    ///     world.models().set_heights(ground, {.column = 400, .row = 250, .columns = 20, .rows = 10}, heights);
    void set_heights(ModelId terrain, const TerrainRectangle& where, std::span<const double> heights);
    /// Lets `change` set cells of a map, for all bodies of the model; if it throws, the cells that it has set stay set.
    /// Cost: proportional to the change; the first change also copies the map, 8 bytes per inner node. Sphere-trees of
    /// the map grow anew. Throws Error{usage} for a model that is not a map.
    ///
    ///     world.models().edit(map, [&](OccupancyMap& cells) { cells.insert_scan(points, origin); });
    void edit(ModelId map, const std::function<void(OccupancyMap&)>& change);
    /// Throws Error{usage} while a body uses it.
    void remove(ModelId model);

    bool contains(ModelId model) const;
    std::size_t size() const; ///< number of models
    /// The model in a slot; null if the slot is free. Slots are less than the greatest number of models so far.
    ModelId at(std::uint32_t slot) const;
    const Geometry& geometry(ModelId model) const; ///< valid until the next change of the model
    /// True for a mesh with an inside: every edge is shared by two triangles that run along it in opposite directions.
    /// Cost: one call of is_closed(), the first time.
    bool closed(ModelId model) const;
    /// The pairs of triangles of a mesh, by number and a < b, that meet beyond the vertices and edges that they share:
    /// some common point is on none of these. Neighbours that fold onto each other or overlap in a plane count, as do
    /// two copies of a triangle. Exact for the vertices as they are. Vertices at equal positions count as one; a
    /// triangle without area counts as the segment or point that it is. Sorted, each pair once. Other kinds of models
    /// do not meet themselves, so they have none. A mesh in a cooked file is read as a whole.
    ///
    /// @param most  the search ends with this many pairs, which depend on the mesh alone
    /// Cost: about 0.15 microseconds per triangle, and one per pair; it uses the World's threads if there is no limit.
    /// Nothing is kept.
    std::vector<PairOf<std::uint32_t>> self_contacts(ModelId model,
                                                     std::size_t most = std::numeric_limits<std::size_t>::max()) const;
    /// As Pairs::near_features() of two bodies of this mesh at one pose, for a barrier between the parts of a mesh that
    /// deforms: all pairs of features at most `dhat` (metres) apart that are not neighbours. Each pair once, with a <
    /// b, sorted; points are in the frame of the mesh. Vertices at equal positions count as one. Throws Error{usage}
    /// for other kinds of models and for options out of range.
    ///
    /// Cost: about 1 microsecond per triangle, and 0.2 per pair; it uses the World's threads. Nothing is kept.
    std::vector<NearFeatures> near_features(ModelId model, double dhat, const SelfNearOptions& options = {}) const;
    /// The AABB of a model at a pose (a motion at rest), or on its whole way, as step() computes it for a body.
    Aabb bounds(ModelId model, const RigidMotion& motion) const;

private:
    friend struct WorldImpl;
    explicit Models(WorldImpl& world) : world_(&world) {}
    WorldImpl* world_;
};

} // namespace oncollide
