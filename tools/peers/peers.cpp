#include "peers/peer.hpp"

namespace oncollide::tools {

Contenders broad_contenders()
{
    Contenders contenders;
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

} // namespace oncollide::tools
