#include <oncollide/narrowphase/solids/shape_tests.hpp>

namespace oncollide {

ConvexMeeting MapShapeTests::meeting(const Pair& pair) const
{
    const Convex solid = convex_of(map_->box(pair.a));
    return ConvexPair(solid, *shape_, *into_, slack_).meeting();
}

ConvexDistance MapShapeTests::bounds(const Pair& pair, const EnoughDistance& enough) const
{
    const Convex solid = convex_of(map_->box(pair.a));
    return ConvexPair(solid, *shape_, *into_, slack_).distance(enough);
}

} // namespace oncollide
