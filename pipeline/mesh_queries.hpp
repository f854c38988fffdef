#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/verdict.hpp>
#include <oncollide/pipeline/contacts.hpp>
#include <oncollide/pipeline/settings.hpp>
#include <oncollide/scenes/geometry.hpp>

namespace oncollide {

/// Do meshes `a` and `b`, by number, collide at these poses?
struct MeshQuery {
    std::uint32_t a, b;
    Eigen::Isometry3d pose_a, pose_b; ///< rigid
};

struct MeshResult {
    Verdict verdict;
    double bound; ///< as PairResult::bound, metres
};

/// Many queries as columns, one entry a query, as numerical programs hold them. A column of one entry serves all.
struct MeshQueryColumns {
    std::span<const std::uint32_t> a, b;      ///< the two, by number
    std::span<const double> poses_a, poses_b; ///< 16 numbers an entry: a rigid 4 x 4 matrix, row by row
};

/// Many queries at once about a few meshes, without a scene: for planners that sample poses. Trees are shared
/// by all queries, grow where these reach, and are kept from call to call.
///
///     MeshQueries queries({robot, house}, {.exact = ExactLevel::predicates, .threads = 0});
///     queries.run(samples, results);
///
/// Not thread-safe: one call uses all its threads itself.
class MeshQueries {
public:
    /// Of the settings depth, max_error, clearance, exact (off or predicates), spheres, threads, age_limit (in calls)
    /// and the budgets count; the automatic bounding volume is obb here. Throws Error{usage} for others than their
    /// defaults, and for a clearance with predicates.
    explicit MeshQueries(std::vector<Mesh> meshes, const Settings& settings = {});
    /// The same about geometries of any kind, which are shared. These have passed the checks of their kinds.
    explicit MeshQueries(std::vector<std::shared_ptr<const Geometry>> geometries, const Settings& settings = {});
    ~MeshQueries();
    MeshQueries(MeshQueries&&) noexcept;

    /// results[i] for queries[i]; the same for any number of threads and in any company. Throws Error{usage} for spans
    /// of different lengths or a mesh that does not exist, Error{bad_data} naming the query whose pose is not rigid.
    void run(std::span<const MeshQuery> queries, std::span<MeshResult> results);
    /// As many queries as there is room for verdicts. Copies no column as a whole. Throws Error{usage} for a column of
    /// another length that is not one entry; where a query is refused, results of those before it may be written.
    void run(const MeshQueryColumns& queries, std::span<Verdict> verdicts, std::span<double> bounds);

    /// The distances, each to `tolerance`; as World::distance(), whose limits these are.
    void distances(std::span<const MeshQuery> queries, double tolerance, std::span<Distance> distances,
                   double farthest = std::numeric_limits<double>::infinity());
    void distances(const MeshQueryColumns& queries, double tolerance, std::span<Distance> distances,
                   double farthest = std::numeric_limits<double>::infinity());

    std::size_t size() const;  ///< how many meshes
    std::size_t bytes() const; ///< of trees, surfaces and lists

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace oncollide
