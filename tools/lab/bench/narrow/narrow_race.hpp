#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "peers/peers.hpp"
#include "study/narrow_poses.hpp"

namespace oncollide::tools {

/// Kinds of queries of a pose: whether the meshes collide, which triangles meet, their distance.
enum class NarrowQuery { boolean, all, distance };
constexpr std::array<std::string_view, 3> query_names{"boolean", "all", "distance"};

bool supports(const NarrowContender& contender, NarrowQuery query);

/// The correct results, by pose.
struct NarrowTruth {
    std::vector<bool> colliding;
    std::vector<std::vector<TrianglePair>> pairs; ///< sorted; empty unless requested
    std::vector<double> distances;                ///< empty unless requested
    std::vector<std::string> notes;               ///< the judges, and differences between them
};

/// Uses the expected results of the poses if there are any; otherwise integers for contacts, and long double for
/// distances.
NarrowTruth judge(const Mesh& a, const Mesh& b, const NarrowWorkload& workload,
                  const std::vector<NarrowQuery>& queries);

/// A contender's results for one kind of query, by pose.
struct QueryResult {
    std::vector<double> us;                   ///< least of the repeats
    std::vector<double> loop_us;              ///< by group: mean in a loop over its poses, least of the repeats
    std::vector<std::uint64_t> missed, extra; ///< boolean: 0 or 1; all: pairs of triangles
    std::vector<double> errors;               ///< of distances, in metres; empty for other queries
    std::vector<std::uint64_t> hashes;        ///< of the result
};

struct NarrowRow {
    const NarrowContender* contender = nullptr;
    std::unique_ptr<NarrowPeer> peer{};
    double build_ms = 0;   ///< time to build its data from two meshes
    double warm_up_ms = 0; ///< time of the warm-up pass over all poses
    double bytes = 0;      ///< growth of the process in both
    std::string figures;   ///< NarrowPeer::figures()
    std::array<std::optional<QueryResult>, 3> queries;
};

/// Runs every query of every pose with every contender, in alternation, each up to `repeats` times in a row (a query is
/// not repeated once it has taken 5 ms), and compares every result with the truth. Then runs the poses of each group in
/// a loop, as often.
std::vector<NarrowRow> race(const Mesh& a, const Mesh& b, const NarrowWorkload& workload, const NarrowTruth& truth,
                            const std::vector<NarrowContender>& contenders, const std::vector<NarrowQuery>& queries,
                            int repeats);

} // namespace oncollide::tools
