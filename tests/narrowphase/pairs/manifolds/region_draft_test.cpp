#include <oncollide/narrowphase/pairs/manifolds/region_draft.hpp>

#include <gtest/gtest.h>

namespace oncollide::region_draft_test {
namespace {

using Eigen::Vector3d;

ManifoldCandidate shared(double x, FeatureBits a, FeatureBits b, const Vector3d& normal = Vector3d::Zero())
{
    return {{x, 0, 0}, ManifoldCandidate::of_both, a, b, 0, 0, true, normal};
}

TEST(RegionDraft, HasEachPairOfFeaturesOnce)
{
    RegionDraft draft;
    draft.begin(RegionKind::touching, false, 0);
    draft.add_shared(shared(1, 5, 7));
    draft.add_shared(shared(2, 5, 7, Vector3d::UnitZ()));
    draft.add_shared(shared(3, 7, 5));
    draft.add_shared(shared(4, 5, 8));
    draft.add_shared(shared(5, 5 ^ 1 << 23, 6)); // the same key as the first pair
    ASSERT_EQ(draft.candidates.size(), 4u);
    EXPECT_EQ(draft.candidates[0].at.x(), 1);
    EXPECT_EQ(draft.candidates[0].normal, Vector3d(Vector3d::UnitZ())) << "the second knows it";
    draft.add_shared(shared(5, 5, 7, Vector3d::UnitX()));
    EXPECT_EQ(draft.candidates[0].normal, Vector3d(Vector3d::UnitZ())) << "and it stays";
}

TEST(RegionDraft, BeginsBlank)
{
    RegionDraft draft;
    draft.begin(RegionKind::crossing, true, 1e-9);
    draft.add_shared(shared(1, 5, 7));
    draft.contacts.emplace_back(1, 2, 3), draft.faces[1].push_back({}), draft.least_depth = 1;
    draft.region.normal = Vector3d::UnitX(), draft.region.area = 3;
    draft.begin(RegionKind::near, false, 1e-8);
    EXPECT_TRUE(draft.candidates.empty() && draft.contacts.empty() && draft.faces[1].empty());
    EXPECT_EQ(draft.region.kind, RegionKind::near);
    EXPECT_FALSE(draft.region.open);
    EXPECT_EQ(draft.rounding, 1e-8);
    EXPECT_EQ(draft.least_depth, 0);
    EXPECT_EQ(draft.region.area, 0);
    EXPECT_EQ(draft.region.normal, Vector3d(Vector3d::Zero()));
    draft.add_shared(shared(2, 5, 7));
    ASSERT_EQ(draft.candidates.size(), 1u) << "it has forgotten the pair";
    EXPECT_EQ(draft.candidates[0].at.x(), 2);
}

} // namespace
} // namespace oncollide::region_draft_test
