// The contenders in this build.
#include "peers/broad/broad_peer.hpp"
#include "peers/contacts/contact_peer.hpp"
#include "peers/narrow/narrow_peer.hpp"
#include "peers/rays/ray_peer.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>

#include "common/text.hpp"

namespace oncollide::tools {

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
template struct ContenderList<RayContender>;
template struct ContenderList<ContactContender>;

BroadContenders broad_contenders()
{
    BroadContenders contenders;
    add_oncollide(contenders.all);
    add_fcl(contenders.all);
#ifdef ONCOLLIDE_WITH_EMBREE
    add_embree(contenders.all);
#else
    contenders.missing.push_back({"Embree", "libembree-dev"});
#endif
#ifdef ONCOLLIDE_WITH_CGAL
    add_cgal(contenders.all);
#else
    contenders.missing.push_back({"CGAL", "libcgal-dev"});
#endif
#ifdef ONCOLLIDE_WITH_BULLET
    add_bullet(contenders.all);
#else
    contenders.missing.push_back({"Bullet", "libbullet-dev"});
#endif
    add_baselines(contenders.all);
    return contenders;
}

NarrowContenders narrow_contenders()
{
    NarrowContenders contenders;
    add_narrow_oncollide(contenders.all);
    add_narrow_fcl(contenders.all);
#ifdef ONCOLLIDE_WITH_EMBREE
    add_narrow_embree(contenders.all);
#else
    contenders.missing.push_back({"Embree", "libembree-dev"});
#endif
#ifdef ONCOLLIDE_WITH_BULLET
    add_narrow_bullet(contenders.all);
#else
    contenders.missing.push_back({"Bullet", "libbullet-dev"});
#endif
#ifdef ONCOLLIDE_WITH_ODE
    add_narrow_ode(contenders.all);
#else
    contenders.missing.push_back({"ODE", "libode-dev"});
#endif
#ifdef ONCOLLIDE_WITH_CGAL
    add_narrow_cgal(contenders.all);
#else
    contenders.missing.push_back({"CGAL", "libcgal-dev"});
#endif
    return contenders;
}

RayContenders ray_contenders()
{
    RayContenders contenders;
#ifdef ONCOLLIDE_WITH_EMBREE
    add_ray_embree(contenders.all);
#else
    contenders.missing.push_back({"Embree", "libembree-dev"});
#endif
#ifdef ONCOLLIDE_WITH_BULLET
    add_ray_bullet(contenders.all);
#else
    contenders.missing.push_back({"Bullet", "libbullet-dev"});
#endif
    return contenders;
}

ContactContenders contact_contenders()
{
    ContactContenders contenders;
    add_contact_fcl(contenders.all);
#ifdef ONCOLLIDE_WITH_BULLET
    add_contact_bullet(contenders.all);
#else
    contenders.missing.push_back({"Bullet", "libbullet-dev"});
#endif
#ifdef ONCOLLIDE_WITH_ODE
    add_contact_ode(contenders.all);
#else
    contenders.missing.push_back({"ODE", "libode-dev"});
#endif
    return contenders;
}

} // namespace oncollide::tools
