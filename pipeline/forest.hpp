#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <oncollide/narrowphase/exact/solid.hpp>
#include <oncollide/narrowphase/spheres/ocst.hpp>
#include <oncollide/narrowphase/spheres/walk.hpp>
#include <oncollide/pipeline/obb_trees.hpp>
#include <oncollide/pipeline/pipeline.hpp>

namespace oncollide {

/// All trees of a scene, of spheres and of oriented boxes, with the budgets and the ageing that they share.
class Forest {
public:
    /// Throws Error{bad_data} for a mesh without inside in solid mode.
    Forest(const Scene& scene, const Settings& settings, std::unique_ptr<OcclusionBackend> backend);

    /// The tree of a geometry, made of its root alone when first asked for.
    Ocst& tree(GeometryId geometry);
    /// The tree of a geometry; null when nobody has asked for it yet.
    const Ocst* grown(GeometryId geometry) const { return trees_[index(geometry)].get(); }
    /// Two bodies at their current poses; their trees are made if need be.
    WalkPair walk_pair(const Scene& scene, std::uint32_t a, std::uint32_t b, LeafPair hint = {});

    /// Sees to it that a mesh has its tree of oriented boxes. False when it is no mesh, or when a budget has no room
    /// for it all grown. Not while walks are under way.
    bool admit_triangles(GeometryId geometry, std::uint32_t frame);
    ObbTrees& obb_trees() { return obb_trees_; } ///< of the geometries admitted
    /// How far apart, above the clearance, two meshes may be that are called near: the error asked for, or what spheres
    /// of that depth would certify. Metres.
    double tolerance(GeometryId a, GeometryId b);

    /// Which geometries have an inside; null in surface mode.
    const Solids* solids() const { return solids_ ? &*solids_ : nullptr; }

    OcclusionBackend& backend() { return *backend_; }
    const OcclusionBackend& backend() const { return *backend_; }

    /// Starts to expand the requested cells (sorted, each once) in one batch. Those over a budget are left; returns how
    /// many. Surfaces are handed to the backend when their tree first grows. Trees do not change until grow().
    std::uint64_t submit(std::span<const CellRequest> requests, int threads);
    /// Waits for the batch and lets the trees grow.
    BatchWork grow(std::uint32_t frame);

    /// A cell whose triangles are asked for.
    struct CellTriangles {
        GeometryId geometry;
        CellKey cell;
    };
    /// Appends the triangles of each cell, none where the tree does not hold its list, and where they end.
    void triangles(std::span<const CellTriangles> cells, std::vector<std::uint32_t>& out,
                   std::vector<std::size_t>& ends);
    /// The cell that holds a point (geometry frame), `up` levels above the leaves but below the root.
    CellKey cell_at(GeometryId geometry, const Eigen::Vector3d& point, int up) const;

    /// Drops cells that no test has reached for the age limit, the oldest sooner while memory is over its budget. A
    /// tree that is back to its root gives its surface up too. Returns how many stored cells went.
    std::uint64_t age(std::uint32_t frame);

    /// Why the GPU no longer answers; empty while it does, or if it never did.
    const std::string& lost() const { return lost_; }

    std::uint64_t nodes() const; ///< stored cells of all sphere-trees, and nodes of oriented boxes
    std::size_t bytes() const;   ///< trees, surfaces and lists

private:
    int depth_for(const RootCell& root, double covering_error) const;
    std::uint64_t cells() const;
    std::size_t sphere_bytes() const;
    std::uint64_t collapse(std::uint32_t frame, std::uint32_t age);
    void attach(std::uint32_t geometry);
    ListId list_of(const CellTriangles& cell) const; ///< all_triangles: not held
    void make_rows(std::span<const CellRequest> requests);
    void take_over(const GpuLost& why);
    template <class Work>
    void survive(Work work);

    const Scene& scene_;
    const Settings settings_;
    std::optional<Solids> solids_;
    std::unique_ptr<OcclusionBackend> backend_;
    ObbTrees obb_trees_;
    std::vector<std::unique_ptr<Ocst>> trees_; ///< by geometry; null until needed
    std::vector<std::uint32_t> live_;          ///< geometries that have a tree
    std::vector<OctantRow> rows_;              ///< of the batch under way
    std::vector<OctantAnswer> answers_;
    std::vector<ListRead> reads_;
    std::vector<std::size_t> read_ends_;
    int threads_ = 1;
    std::string lost_;
};

} // namespace oncollide
