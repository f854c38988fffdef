#include <gtest/gtest.h>

#include <oncollide/base/text/near_word.hpp>

namespace oncollide {
namespace {

TEST(NearWord, TheNearestNameIsProposedAndNoneWhereAllAreFar)
{
    const std::vector<std::string_view> names{"kd", "octree", "brute", "--max-error", "--depth"};
    EXPECT_EQ(did_you_mean("octre", names), "; did you mean 'octree'?");
    EXPECT_EQ(did_you_mean("--dpeth", names), "; did you mean '--depth'?");
    EXPECT_EQ(did_you_mean("ke", names), "; did you mean 'kd'?");
    EXPECT_EQ(did_you_mean("--error", names), "; did you mean '--max-error'?") << "a part of it";
    for (const char* far : {"", "x", "-", "--", "narrow", "elephant"}) EXPECT_EQ(did_you_mean(far, names), "") << far;
    EXPECT_EQ(did_you_mean(std::string(100'000, 'o'), names), "");
    EXPECT_EQ(did_you_mean("octre", {}), "");
}

TEST(NearWord, ValidNamesFollowTheHint)
{
    EXPECT_EQ(valid_names("octre", {"kd", "octree"}), "; did you mean 'octree'? valid: kd, octree");
    EXPECT_EQ(valid_names("lunch", {"kd", "octree"}, "there are"), "; there are: kd, octree");
}

} // namespace
} // namespace oncollide
