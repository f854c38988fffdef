#pragma once
#include <memory>
#include <string>
#include <vector>

#include <oncollide/pipeline/settings.hpp>

#include "study/workload.hpp"

// Who plays a study beside the variants: other libraries, each as well as it can be used.
namespace oncollide::tools {

/// A library at work on a workload.
class StudyPlayer {
public:
    virtual ~StudyPlayer() = default;
    struct Result {
        double ms = 0;
        std::uint64_t candidates = 0;
        std::vector<BodyPair> colliding; ///< sorted
    };
    /// Of the scene as it stands.
    virtual Result step() = 0;
    virtual std::size_t bytes() const = 0; ///< of what it built
};

/// A library as --peers names it.
struct PeerKind {
    std::string name, library;
    std::string broad, narrow; ///< contenders of 'bench broad' and 'bench narrow'; FCL has a world of its own
};

/// Empty: those that keep a tree of either mesh; Embree and CGAL go through all of a mesh for each query. Else
/// "all", "none", or names with commas. Throws Error{usage} that lists the names.
std::vector<PeerKind> peers_from_names(const std::string& list);

/// Takes out those that are not in this build or have no such query, and says why, a line each.
std::vector<std::string> leave_out(std::vector<PeerKind>& kinds, const StudyWorkload& workload,
                                   const Settings& request);

/// Builds models, trees and objects; the workload's scene must outlive it.
std::unique_ptr<StudyPlayer> make_player(const PeerKind& kind, const StudyWorkload& workload);

// The parts of the above for those that know triangles only.

/// Why these cannot play the scene; empty when they can.
std::string why_not(const PeerKind& kind, const Scene& scene);
/// One structure for each two geometries whose bodies may meet, made now. A scene's pairs come from the broad phase,
/// over our boxes; two meshes in poses have no need of one.
std::unique_ptr<StudyPlayer> make_mesh_player(const PeerKind& kind, const StudyWorkload& workload);

} // namespace oncollide::tools
