#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

#include "study/pose_file.hpp"

namespace oncollide::tools {

/// A pose to query.
struct NarrowPose {
    KnownPose known;
    std::size_t group;                   ///< in NarrowWorkload::groups
    std::size_t number = 0;              ///< in the file
    std::optional<double> distance = {}; ///< requested distance of the surfaces
};

/// All poses of a benchmark, group by group.
struct NarrowWorkload {
    std::vector<std::string> groups; ///< "5 %": a distance; "within 2 %": a kind in a pose file, by its largest offset
    std::vector<NarrowPose> poses;
};

/// Parses --distances, "0,0.1,1,5", to ascending unique percentages. Throws Error{usage}.
std::vector<double> parse_distances(const std::string& list);

/// Random poses of `b` around `a`: `count` orientations, directions and contact positions, each at all distances.
/// A distance is between the surfaces, in percent of the diagonal of a's AABB. 0: just touching, then moved by 1e-6 of
/// the diagonal alternately out of contact and into it. Negative: moved in by this much from touching. Deterministic
/// for equal arguments. Throws Error{bad_data} if the meshes cannot be made to touch. Cost per pose: about ten distance
/// queries and forty collision queries of FCL. Shows progress.
NarrowWorkload make_workload(const Mesh& a, const Mesh& b, std::span<const double> percents, std::size_t count,
                             std::uint64_t seed);

/// The poses of a file, grouped by kind.
NarrowWorkload workload_of(std::vector<KnownPose> poses);

} // namespace oncollide::tools
