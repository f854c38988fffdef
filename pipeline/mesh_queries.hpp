#pragma once
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/pipeline/settings.hpp>
#include <oncollide/scenes/geometry.hpp>

namespace oncollide {

// --- Two meshes at two poses, in one line. Poses are rigid: body frame to world, metres.
// Each call builds its trees (5 ns per triangle, 60 ns per traversed triangle); a World keeps them.
// Throw Error{bad_data} for poses that are not rigid, and for a mesh that make_mesh would refuse.

/// Exact: the verdict is separate or colliding; touching counts as colliding.
ONCOLLIDE_API Finding collide(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b,
                              const Eigen::Isometry3d& pose_b);

/// As World::distance().
ONCOLLIDE_API Distance distance(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b,
                                const Eigen::Isometry3d& pose_b, double tolerance = 0,
                                double cutoff = std::numeric_limits<double>::infinity());

/// As World::contacts().
ONCOLLIDE_API std::vector<Contact> contacts(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b,
                                            const Eigen::Isometry3d& pose_b);

// --- Many queries.

/// Two meshes, by number, at two poses.
struct MeshQuery {
    std::uint32_t a, b;
    Eigen::Isometry3d pose_a, pose_b; ///< rigid
};

/// Many queries as columns, one entry per query, as numerical programs hold them. A column of one entry serves all.
struct MeshQueryColumns {
    std::span<const std::uint32_t> a, b;      ///< the two, by number
    std::span<const double> poses_a, poses_b; ///< 16 numbers per entry: a rigid 4 x 4 matrix, row by row
};

/// Many queries at once about a few meshes that are known by number: for planners that sample poses. A thin layer over
/// World::decide() and World::distances(); trees are kept from call to call.
///
///     MeshQueries queries({robot, house}, {.exact = ExactLevel::predicates, .threads = 0});
///     queries.run(samples, results);
///
/// Not thread-safe: one call uses all its threads itself.
class ONCOLLIDE_API MeshQueries {
public:
    /// Settings that count: depth, max_error, clearance, exact (off or predicates), bounding_volume (automatic means
    /// obb), threads, age_limit (in calls) and the budgets. Throws Error{usage} if another one differs from its
    /// default, and for a clearance with predicates.
    explicit MeshQueries(std::vector<Mesh> meshes, const Settings& settings = {});
    /// The same for geometries of any kind, which are shared and have passed the checks of their kinds.
    explicit MeshQueries(std::vector<std::shared_ptr<const Geometry>> geometries, const Settings& settings = {});
    ~MeshQueries();
    MeshQueries(MeshQueries&&) noexcept;

    /// results[i] for queries[i]. Throws Error{usage} for spans of different lengths or a mesh that does not exist,
    /// Error{bad_data} that names the query whose pose is not rigid.
    void run(std::span<const MeshQuery> queries, std::span<Finding> results);
    /// Runs verdicts.size() queries. Throws Error{usage} for a column of another length that is not
    /// one entry; if a query is refused, results of queries before it may have been written.
    void run(const MeshQueryColumns& queries, std::span<Verdict> verdicts, std::span<double> bounds);

    /// As World::distances().
    void distances(std::span<const MeshQuery> queries, double tolerance, std::span<Distance> distances,
                   double cutoff = std::numeric_limits<double>::infinity());
    void distances(const MeshQueryColumns& queries, double tolerance, std::span<Distance> distances,
                   double cutoff = std::numeric_limits<double>::infinity());

    std::size_t size() const;  ///< number of meshes
    std::size_t bytes() const; ///< of trees, surfaces and lists

private:
    struct ONCOLLIDE_LOCAL Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace oncollide
