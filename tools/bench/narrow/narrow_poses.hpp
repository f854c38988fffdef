#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

#include "bench/narrow/pose_file.hpp"

namespace oncollide::tools {

/// A pose to be queried.
struct NarrowPose {
    KnownPose known;
    std::size_t group;                   ///< of NarrowWorkload::groups
    std::optional<double> distance = {}; ///< of the surfaces, as it was requested
};

/// All poses of a benchmark, group by group.
struct NarrowWorkload {
    std::vector<std::string> groups; ///< "5 %": so far apart; "within 2 %": the reach of one kind in a pose file
    std::vector<NarrowPose> poses;
};

/// "0,0.1,1,5" of --distances as percents, ascending, each once. Throws Error{usage}.
std::vector<double> parse_distances(const std::string& list);

/// Random poses of `b` around `a`: `count` orientations, directions and places of contact, each at all distances.
/// A distance is that of the surfaces, in percent of the diagonal of a's box. 0: just touching, then moved by 1e-6 of
/// the diagonal out of contact and into it, alternately. Negative: moved in from touching by so much.
/// Deterministic for equal arguments. Throws Error{bad_data} when the meshes cannot be made to touch.
/// Cost: about ten of FCL's distances and forty of its yes or no a pose; shown while it lasts.
NarrowWorkload make_workload(const Mesh& a, const Mesh& b, std::span<const double> percents, std::size_t count,
                             std::uint64_t seed);

/// The poses of a file, grouped by kind.
NarrowWorkload workload_of(std::vector<KnownPose> poses);

} // namespace oncollide::tools
