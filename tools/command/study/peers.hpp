#pragma once
#include <functional>
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
    std::string package; ///< Debian's, of a library that this build lacks; empty: the build has it
    bool by_default = true;
    /// The reason why the library cannot play the scene; empty if it can.
    std::function<std::string(const Scene&)> why_not;
    /// Builds models, trees and objects; the workload's scene must outlive it.
    std::function<std::unique_ptr<StudyPlayer>(const StudyWorkload&)> make;
};

/// FCL, which the library links as an exact level. oncollide-lab has more.
PeerKind fcl_peer();

/// Parses "all", "none", or a comma-separated list of names of `all`; empty: the libraries that play by default. Throws
/// Error{usage} that lists the names.
std::vector<PeerKind> peers_from_names(const std::vector<PeerKind>& all, const std::string& list);

/// Removes libraries that are not in this build or lack such a query. Returns one line per library with the reason.
std::vector<std::string> leave_out(std::vector<PeerKind>& kinds, const StudyWorkload& workload,
                                   const Settings& request);

} // namespace oncollide::tools
