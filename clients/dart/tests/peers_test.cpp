// DART's own tests, as its source has them, with oncollide in place of each of DART's detectors. One unit, as DART's
// headers take ten seconds; each file has a namespace.
#include <iostream>

#include <dart/utils/sdf/SdfParser.hpp>
#include <dart/utils/utils.hpp>
#include <gtest/gtest.h>

#include "as_peers.hpp"

#include <TestHelpers.hpp>

namespace test_collision {
#include "comprehensive/test_Collision.cpp"
}
namespace test_distance {
#include "comprehensive/test_Distance.cpp"
}
namespace test_raycast {
#include "comprehensive/test_Raycast.cpp"
}
namespace test_slip {
#include "comprehensive/test_ForceDependentSlip.cpp"
}
namespace test_friction {
#include "comprehensive/test_Friction.cpp"
}
namespace test_groups {
#include "unit/test_CollisionGroups.cpp"
}
namespace test_1184 {
#include "regression/test_Issue1184.cpp"
}
namespace test_1231 {
#include "regression/test_Issue1231.cpp"
}
namespace test_1234 {
#include "regression/test_Issue1234.cpp"
}
namespace test_1243 {
#include "regression/test_Issue1243.cpp"
}
namespace test_1445 {
#include "regression/test_Issue1445.cpp"
}
namespace test_1624 {
#include "regression/test_Issue1624.cpp"
}
