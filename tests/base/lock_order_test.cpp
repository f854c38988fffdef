// The order of the mutexes is asserted in builds with assertions; this file always has them.
#ifndef ONCOLLIDE_ASSERTIONS
#define ONCOLLIDE_ASSERTIONS
#endif

#include <thread>

#include <gtest/gtest.h>

#include <oncollide/base/threads/lock_order.hpp>

namespace oncollide::lock_order_test {
namespace {

OrderedMutex<LockRank::world, SharedMutex> world;
OrderedMutex<LockRank::chunks> chunks;
OrderedMutex<LockRank::cooked_file> file;

TEST(LockOrder, AllowsMutexesOfLaterRanksInAnyThread)
{
    const std::shared_lock first(world);
    const std::lock_guard second(chunks);
    const std::lock_guard third(file);
    std::thread([] { const std::shared_lock alone(world); }).join();
}

TEST(LockOrder, AllowsAnyRankOnceAllAreReleased)
{
    {
        std::unique_lock first(chunks);
        const std::lock_guard second(file);
        first.unlock();
    }
    const std::lock_guard first(world);
}

TEST(LockOrder, DiesIfAnEarlierMutexIsLockedLast)
{
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_DEATH(
        {
            const std::lock_guard first(file);
            const std::lock_guard second(chunks);
        },
        "LockRank");
    EXPECT_DEATH(
        {
            const std::lock_guard first(chunks);
            const std::shared_lock second(world);
        },
        "LockRank");
}

TEST(LockOrder, DiesIfAThreadHoldsTwoMutexesOfOneRank)
{
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    OrderedMutex<LockRank::chunks> others;
    EXPECT_DEATH(
        {
            const std::lock_guard first(chunks);
            const std::lock_guard second(others);
        },
        "LockRank");
}

} // namespace
} // namespace oncollide::lock_order_test
