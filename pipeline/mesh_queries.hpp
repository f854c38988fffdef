#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/verdict.hpp>
#include <oncollide/pipeline/contacts.hpp>
#include <oncollide/pipeline/settings.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// Do meshes `a` and `b`, by number, collide at these poses?
struct MeshQuery {
    std::uint32_t a, b;
    Eigen::Isometry3d pose_a, pose_b; ///< rigid
};

struct MeshAnswer {
    Verdict verdict;
    double bound; ///< as PairResult::bound, metres
};

/// Many questions at once about a few meshes, without a scene: for planners that sample poses. Sphere-trees are shared
/// by all questions, grow where these reach, and are kept from call to call.
///
///     MeshQueries queries({robot, house}, {.exact = ExactLevel::predicates, .threads = 0});
///     queries.ask(samples, answers);
///
/// Not thread-safe: one call uses all its threads itself.
class MeshQueries {
public:
    /// Of the settings depth, max_error, clearance, exact (off or predicates), bounding_volume, threads, age_limit (in
    /// calls) and the budgets count; the automatic bounding volume is OBBs here. Throws Error{usage} for others than
    /// their defaults, and for a clearance with predicates.
    explicit MeshQueries(std::vector<Mesh> meshes, const Settings& settings = {});
    ~MeshQueries();
    MeshQueries(MeshQueries&&) noexcept;

    /// answers[i] for queries[i]; the same for any number of threads and in any company. Throws Error{usage} for spans
    /// of different lengths or a mesh that does not exist, Error{bad_data} naming the query whose pose is not rigid.
    void ask(std::span<const MeshQuery> queries, std::span<MeshAnswer> answers);

    /// The distances, each to `tolerance`; as ContactFinder::distance(), whose limits and errors these are.
    void distances(std::span<const MeshQuery> queries, double tolerance, std::span<MeshDistance> distances,
                   double farthest = std::numeric_limits<double>::infinity());

    std::size_t bytes() const; ///< of trees, surfaces and lists

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace oncollide
