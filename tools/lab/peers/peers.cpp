// The contenders in this build.
#include "peers/peers.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>

#include "common/text.hpp"

namespace oncollide::tools {
namespace {

/// A library that a build may lack.
struct OptionalLibrary {
    const char *name, *package;   ///< Debian's
    void (*add)(Contenders& all); ///< null: this build lacks it
    bool broad, narrow, rays, contacts, physics, self = false, deform = false;
};

/// `add` refers to a function that is linked only if the library is there.
template <bool there>
constexpr auto if_there(auto add) -> void (*)(Contenders&)
{
    if constexpr (there) return add;
    return nullptr;
}

constexpr OptionalLibrary optional_libraries[] = {
    // adds                                                               broad, narrow, rays, contacts, physics, self,
    // deform
    {"Embree", "libembree-dev", if_there<WITH_EMBREE>([](auto& all) { add_embree(all); }), true, true, true, false,
     false, false, true},
    {"Bullet", "libbullet-dev", if_there<WITH_BULLET>([](auto& all) { add_bullet(all); }), true, true, true, true, true,
     false, true},
    {"ODE", "libode-dev", if_there<WITH_ODE>([](auto& all) { add_ode(all); }), false, true, false, true, false},
    {"CGAL", "libcgal-dev", if_there<WITH_CGAL>([](auto& all) { add_cgal(all); }), true, true, false, false, false,
     true}};

} // namespace

void print_missing(std::span<const MissingPeer> missing)
{
    for (const MissingPeer& peer : missing) say("{:<11}not in this build (Debian: {})\n", peer.library, peer.package);
}

template <class Kind>
void ContenderList<Kind>::keep(const std::string& only)
{
    if (only.empty()) return;
    std::vector<std::string> names;
    for (const Kind& contender : all) names.push_back(contender.name);
    std::vector<Kind> chosen;
    for (const std::string& name : split(only)) {
        const auto found = std::ranges::find(all, name, &Kind::name);
        if (found == all.end())
            throw Error(ErrorKind::usage,
                        fmt::format("--only {}: unknown contender; this build has: {}", name, fmt::join(names, ", ")));
        if (std::ranges::find(chosen, name, &Kind::name) == chosen.end()) chosen.push_back(*found);
    }
    all = std::move(chosen);
}

template struct ContenderList<BroadContender>;
template struct ContenderList<NarrowContender>;
template struct ContenderList<SelfContender>;
template struct ContenderList<DeformContender>;
template struct ContenderList<RayContender>;
template struct ContenderList<ContactContender>;
template struct ContenderList<PhysicsContender>;

Contenders all_contenders()
{
    Contenders all;
    add_oncollide(all);
    add_deform(all);
    add_fcl(all), add_fcl_deform(all);
    for (const OptionalLibrary& library : optional_libraries) {
        if (library.add) {
            library.add(all);
            continue;
        }
        const auto misses = [&](bool has, auto& list) {
            if (has) list.missing.push_back({library.name, library.package});
        };
        misses(library.broad, all.broad), misses(library.narrow, all.narrow);
        misses(library.rays, all.rays), misses(library.contacts, all.contacts);
        misses(library.physics, all.physics), misses(library.self, all.self);
        misses(library.deform, all.deform);
    }
    add_baselines(all);
    return all;
}

} // namespace oncollide::tools
