#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bench/narrow/narrow_poses.hpp"
#include "peers/narrow_peer.hpp"

namespace oncollide::tools {

/// What can be requested of a pose: do they collide, which triangles meet, how far apart are they.
enum class NarrowQuery { boolean, all, distance };
constexpr std::array<std::string_view, 3> query_names{"boolean", "all", "distance"};

bool supports(const NarrowContender& contender, NarrowQuery query);

/// The right results, by pose.
struct NarrowTruth {
    std::vector<bool> colliding;
    std::vector<std::vector<TrianglePair>> pairs; ///< sorted; empty unless requested
    std::vector<double> distances;                ///< empty unless requested
    std::vector<std::string> notes;               ///< who judged, and where judges differ
};

/// What is expected of each pose comes first; else CGAL's exact result, where this build has it, else FCL's. Distances
/// are FCL's.
NarrowTruth judge(const Mesh& a, const Mesh& b, const NarrowWorkload& workload,
                  const std::vector<NarrowQuery>& queries);

/// What one contender did with one query, by pose.
struct QueryResult {
    std::vector<double> us;                   ///< the least of the repeats
    std::vector<std::uint64_t> missed, extra; ///< boolean: 0 or 1; all: pairs of triangles
    std::vector<double> errors;               ///< of distances, metres; empty for other queries
    std::vector<std::uint64_t> hashes;        ///< of the result
};

struct NarrowRow {
    const NarrowContender* contender = nullptr;
    double build_ms = 0;   ///< from two meshes to being ready
    double warm_up_ms = 0; ///< the pass over all poses that is not counted
    double bytes = 0;      ///< by which the process grew in both
    std::array<std::optional<QueryResult>, 3> queries;
};

/// Puts every query of every pose to every contender, turn about, each up to `repeats` times in a row (a query is not
/// repeated once it has taken 5 ms), and compares every result with the truth.
std::vector<NarrowRow> race(const Mesh& a, const Mesh& b, const NarrowWorkload& workload, const NarrowTruth& truth,
                            const std::vector<NarrowContender>& contenders, const std::vector<NarrowQuery>& queries,
                            int repeats);

} // namespace oncollide::tools
