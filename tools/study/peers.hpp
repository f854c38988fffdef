#pragma once
#include <memory>
#include <string>
#include <vector>

#include <oncollide/pipeline/settings.hpp>

#include "study/workload.hpp"

// The other libraries in a study, each used as well as possible.
namespace oncollide::tools {

/// A library that plays a workload.
class StudyPlayer {
public:
    virtual ~StudyPlayer() = default;
    struct Result {
        double ms = 0;
        std::uint64_t candidates = 0;
        std::vector<BodyPair> colliding; ///< sorted
    };
    /// Plays the scene at its current poses.
    virtual Result step() = 0;
    virtual std::size_t bytes() const = 0; ///< of its models and trees
};

/// A library by its name in --peers.
struct PeerKind {
    std::string name, library;
    std::string broad, narrow; ///< contenders of 'bench broad' and 'bench narrow'; FCL uses its own world
};

/// Parses "all", "none", or a comma-separated list. Empty: the libraries that keep a tree of both meshes; Embree and
/// CGAL process a whole mesh per query. Throws Error{usage} that lists the names.
std::vector<PeerKind> peers_from_names(const std::string& list);

/// Removes libraries that are not in this build or lack such a query. Returns one line per library with the reason.
std::vector<std::string> leave_out(std::vector<PeerKind>& kinds, const StudyWorkload& workload,
                                   const Settings& request);

/// Builds models, trees and objects; the workload's scene must outlive it.
std::unique_ptr<StudyPlayer> make_player(const PeerKind& kind, const StudyWorkload& workload);

// Parts of the above for libraries that support only triangles.

/// The reason why the library cannot play the scene; empty if it can.
std::string why_not(const PeerKind& kind, const Scene& scene);
/// Makes one structure per pair of geometries whose bodies may collide. A scene's pairs come from the broad phase
/// `broad`, over AABBs of oncollide; two meshes in poses need none.
std::unique_ptr<StudyPlayer> make_mesh_player(const PeerKind& kind, const StudyWorkload& workload);

} // namespace oncollide::tools
