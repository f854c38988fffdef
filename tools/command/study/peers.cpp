#include "study/peers.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/narrowphase/fcl/exact_fcl.hpp>

#include "common/text.hpp"
#include "fcl/fcl_world.hpp"

namespace oncollide::tools {
namespace {

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

} // namespace

PeerKind fcl_peer()
{
    return {.name = "fcl",
            .library = "FCL",
            .package = fcl_available() ? "" : "libfcl-dev",
            .why_not = [](const Scene&) { return std::string(); },
            .make = [](const StudyWorkload& workload) { return std::make_unique<FclPlayer>(workload.scene); }};
}

std::vector<PeerKind> peers_from_names(const std::vector<PeerKind>& all, const std::string& list)
{
    std::vector<PeerKind> chosen;
    if (list == "none") return chosen;
    if (list == "all") return all;
    if (list.empty()) {
        std::ranges::copy_if(all, std::back_inserter(chosen), &PeerKind::by_default);
        return chosen;
    }
    std::vector<std::string_view> names;
    for (const PeerKind& kind : all) names.push_back(kind.name);
    names.insert(names.end(), {"all", "none"});
    for (const std::string& name : split(list)) {
        const auto at = std::ranges::find(all, name, &PeerKind::name);
        if (at == all.end())
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
        if (!kind.package.empty())
            why = fmt::format("not in this build (Debian: {})", kind.package);
        else if (why.empty())
            why = kind.why_not(workload.scene);
        if (!why.empty()) notes.push_back(fmt::format("{}: {}", kind.library, why));
        return !why.empty();
    });
    return notes;
}

} // namespace oncollide::tools
