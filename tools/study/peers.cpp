#include "study/peers.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/text/near_word.hpp>

#include "common/text.hpp"
#include "peers/fcl_world.hpp"
#include "peers/narrow/narrow_peer.hpp"

namespace oncollide::tools {
namespace {

const std::vector<PeerKind>& all_kinds()
{
    static const std::vector<PeerKind> kinds{{"fcl", "FCL", "", ""},
                                             {"ode", "ODE", "kd", "ode"}, // ODE's own spaces are not measured
                                             {"bullet", "Bullet", "bullet-dbvt", "bullet-gimpact"},
                                             {"embree", "Embree", "embree-rebuild", "embree-refit"},
                                             {"cgal", "CGAL", "cgal", "cgal"}};
    return kinds;
}

class FclPlayer final : public StudyPlayer {
public:
    explicit FclPlayer(const Scene& scene) : world_(scene) {}

    Result step() override
    {
        const FclFrame frame = world_.step();
        return {frame.ms(), frame.candidates, {frame.colliding.begin(), frame.colliding.end()}};
    }
    std::size_t bytes() const override { return world_.model_bytes().obb; }

private:
    FclWorld world_;
};

/// Requests that no peer supports; empty: none.
std::string why_not_by_peers(const Settings& request)
{
    if (request.clearance > 0) return "has no query for a clearance";
    if (request.mode == Mode::solid) return "has no query for solids";
    return request.ignore_touching ? "cannot ignore touching pairs" : "";
}

/// Debian's package of a library that this build lacks; empty: the build has it.
std::string missing_package(const PeerKind& kind)
{
    for (const MissingPeer& peer : narrow_contenders().missing)
        if (peer.library == kind.library) return peer.package;
    return {};
}

} // namespace

std::vector<PeerKind> peers_from_names(const std::string& list)
{
    if (list == "none") return {};
    if (list == "all") return all_kinds();
    std::vector<std::string_view> names;
    for (const PeerKind& kind : all_kinds()) names.push_back(kind.name);
    names.insert(names.end(), {"all", "none"});
    std::vector<PeerKind> chosen;
    for (const std::string& name : split(list.empty() ? "fcl,ode,bullet" : list)) {
        const auto at = std::ranges::find(all_kinds(), name, &PeerKind::name);
        if (at == all_kinds().end())
            throw Error(ErrorKind::usage,
                        fmt::format("--peers {}: unknown peer{}", name, valid_names(name, names, "valid")));
        if (std::ranges::find(chosen, name, &PeerKind::name) == chosen.end()) chosen.push_back(*at);
    }
    return chosen;
}

std::vector<std::string> leave_out(std::vector<PeerKind>& kinds, const StudyWorkload& workload, const Settings& request)
{
    std::vector<std::string> notes;
    std::erase_if(kinds, [&](const PeerKind& kind) {
        std::string why = why_not_by_peers(request);
        if (const std::string package = missing_package(kind); !package.empty())
            why = fmt::format("not in this build (Debian: {})", package);
        else if (why.empty() && kind.name != "fcl")
            why = why_not(kind, workload.scene);
        if (!why.empty()) notes.push_back(fmt::format("{}: {}", kind.library, why));
        return !why.empty();
    });
    return notes;
}

std::unique_ptr<StudyPlayer> make_player(const PeerKind& kind, const StudyWorkload& workload)
{
    if (kind.name == "fcl") return std::make_unique<FclPlayer>(workload.scene);
    return make_mesh_player(kind, workload);
}

} // namespace oncollide::tools
