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
    /// The kinds of contenders that it adds.
    bool broad = false, narrow = false, rays = false, contacts = false, physics = false, self = false, deform = false;
};

/// `add` refers to a function that is linked only if the library is there.
template <bool there>
constexpr auto if_there(auto add) -> void (*)(Contenders&)
{
    if constexpr (there) return add;
    return nullptr;
}

constexpr OptionalLibrary optional_libraries[] = {{.name = "Embree",
                                                   .package = "libembree-dev",
                                                   .add = if_there<WITH_EMBREE>([](auto& all) { add_embree(all); }),
                                                   .broad = true,
                                                   .narrow = true,
                                                   .rays = true,
                                                   .deform = true},
                                                  {.name = "Bullet",
                                                   .package = "libbullet-dev",
                                                   .add = if_there<WITH_BULLET>([](auto& all) { add_bullet(all); }),
                                                   .broad = true,
                                                   .narrow = true,
                                                   .rays = true,
                                                   .contacts = true,
                                                   .physics = true,
                                                   .deform = true},
                                                  {.name = "ODE",
                                                   .package = "libode-dev",
                                                   .add = if_there<WITH_ODE>([](auto& all) { add_ode(all); }),
                                                   .narrow = true,
                                                   .contacts = true},
                                                  {.name = "CGAL",
                                                   .package = "libcgal-dev",
                                                   .add = if_there<WITH_CGAL>([](auto& all) { add_cgal(all); }),
                                                   .broad = true,
                                                   .narrow = true,
                                                   .self = true}};

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
