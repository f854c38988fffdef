#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <oncollide/pipeline/refine/pair_cache.hpp>

namespace oncollide::pair_cache_test {
namespace {

using Pairs = std::vector<BodyPair>;

TEST(PairCache, RemembersAPairWhileItIsACandidate)
{
    PairCache cache;
    cache.begin_frame(Pairs{{0, 1}, {0, 2}, {3, 4}}, {}, {});
    for (std::size_t i = 0; i < 3; ++i) cache[i].part(double(i + 1), 0);
    EXPECT_EQ(cache.validate(), "");
    cache.begin_frame(Pairs{{0, 2}, {1, 2}, {3, 4}}, {}, {});
    EXPECT_GT(cache[0].gap(0), 1.9);
    EXPECT_LE(cache[1].gap(0), 0) << "a new pair has no memory";
    EXPECT_GT(cache[2].gap(0), 2.9);
    EXPECT_EQ(cache.validate(), "");
    cache.begin_frame(Pairs{{0, 1}, {0, 2}}, {}, {});
    EXPECT_LE(cache[0].gap(0), 0) << "it was no candidate in the last frame";
    EXPECT_GT(cache[1].gap(0), 1.9);
    EXPECT_EQ(cache.validate(), "");
}

TEST(PairCache, ForgetsThePairsOfBodiesThatAreNewOrHaveANewGeometry)
{
    PairCache cache;
    const Pairs pairs{{0, 1}, {0, 2}, {1, 2}};
    cache.begin_frame(pairs, {}, {});
    for (std::size_t i = 0; i < 3; ++i) cache[i].meet(0.5, 0);
    const std::vector<std::uint8_t> fresh{0, 1, 0};
    cache.begin_frame(pairs, fresh, fresh);
    EXPECT_LE(cache[0].depth(0), 0);
    EXPECT_GT(cache[1].depth(0), 0);
    EXPECT_LE(cache[2].depth(0), 0);
}

TEST(PairCache, ListsRunsOfPairsWhoseBodiesDidNotChange)
{
    PairCache cache;
    cache.begin_frame(Pairs{{0, 1}, {0, 2}, {1, 2}, {3, 4}, {3, 5}, {6, 7}}, {}, {});
    EXPECT_TRUE(cache.unchanged().empty());
    const std::vector<std::uint8_t> changed{0, 1, 0, 0, 0, 0, 0, 0, 0};
    const Pairs pairs{{0, 2}, {0, 8}, {1, 2}, {3, 4}, {3, 5}};
    cache.begin_frame(pairs, changed, {});
    const auto runs = cache.unchanged();
    ASSERT_EQ(runs.size(), 2u);
    EXPECT_TRUE(runs[0].now == 0 && runs[0].before == 1 && runs[0].count == 1);
    EXPECT_TRUE(runs[1].now == 3 && runs[1].before == 3 && runs[1].count == 2);
    cache.begin_frame(pairs, {}, {});
    ASSERT_EQ(cache.unchanged().size(), 1u);
    EXPECT_EQ(cache.unchanged()[0].count, pairs.size());
}

TEST(PairCache, ReusesTheRowsOfPairsThatAreGone)
{
    PairCache cache;
    constexpr std::uint32_t candidates = 50; // in each frame
    for (std::uint32_t frame = 0; frame < 50; ++frame) {
        Pairs pairs;
        for (std::uint32_t i = 0; i < 2 * candidates; ++i)
            if ((i * 7 + frame * 13) % 10 < 5) pairs.push_back({i, i + 1 + frame % 3});
        ASSERT_EQ(pairs.size(), candidates);
        cache.begin_frame(pairs, {}, {});
        ASSERT_EQ(cache.validate(), "") << frame;
    }
    EXPECT_LT(cache.bytes(), 6 * candidates * (sizeof(PairMemory) + 40)) << "far fewer rows than pairs there were";
    cache.begin_frame({}, {}, {});
    EXPECT_EQ(cache.validate(), "");
}

TEST(PairCache, MotionUsesUpAGapAndADepthButNeverTooLittle)
{
    PairMemory memory;
    memory.part(1, 10);
    EXPECT_LE(memory.gap(10), 1);
    EXPECT_NEAR(memory.gap(10.25), 0.75, 1e-12);
    EXPECT_LE(memory.gap(11), 0) << "it moved by all of the gap";
    memory.part(0.5, 10);
    EXPECT_NEAR(memory.gap(10), 1, 1e-12) << "a weaker bound does not replace it";
    memory.meet(2, 10);
    EXPECT_LE(memory.depth(12), 0);
    EXPECT_GT(memory.depth(11.99), 0);
}

TEST(PairCache, NamesAPairThatRemembersNoNumber)
{
    PairCache cache;
    cache.begin_frame(Pairs{{0, 1}, {0, 2}}, {}, {});
    EXPECT_EQ(cache.validate(), "");
    cache[1].apart_until = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(cache.validate(), "pair (0, 2): remembers a distance that is not a number");
}

#ifdef ONCOLLIDE_ASSERTIONS
TEST(PairCache, DiesOfPairsThatAreNotSorted)
{
    PairCache cache;
    EXPECT_DEATH(cache.begin_frame(Pairs{{0, 2}, {0, 1}}, {}), "contract broken");
}
#else
TEST(PairCache, NamesPairsThatAreNotInOrder)
{
    PairCache cache;
    cache.begin_frame(Pairs{{0, 2}, {0, 1}}, {}, {});
    EXPECT_EQ(cache.validate(), "pair (0, 1): is not in order");
}
#endif

} // namespace
} // namespace oncollide::pair_cache_test
