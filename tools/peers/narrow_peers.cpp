#include "peers/narrow_peer.hpp"

namespace oncollide::tools {

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

} // namespace oncollide::tools
