#include <atomic>
#include <vector>

#include <gtest/gtest.h>

#include <oncollide/base/parallel.hpp>

namespace oncollide {
namespace {

TEST(ParallelChunks, CoversEveryItemOnceForAnyCountGrainAndThreads)
{
    for (const std::size_t count : {1u, 2u, 7u, 64u, 1000u})
        for (const std::size_t grain : {0u, 1u, 3u, 64u, 5000u})
            for (const int threads : {-1, 0, 1, 2, 3, 8, 100}) {
                std::vector<std::atomic<int>> visits(count);
                std::atomic<bool> in_range{true};
                parallel_chunks(count, grain, threads, [&](std::size_t begin, std::size_t end, int thread) {
                    if (begin >= end || end > count || thread < 0 || thread >= std::max(threads, 1)) in_range = false;
                    for (std::size_t i = begin; i < end; ++i) ++visits[i];
                });
                EXPECT_TRUE(in_range) << count << " " << grain << " " << threads;
                for (std::size_t i = 0; i < count; ++i)
                    ASSERT_EQ(visits[i], 1)
                        << "item " << i << " of " << count << ", grain " << grain << ", " << threads;
            }
}

TEST(ParallelChunks, DoesNothingForNoItems)
{
    bool called = false;
    parallel_chunks(0, 10, 4, [&](std::size_t, std::size_t, int) { called = true; });
    EXPECT_FALSE(called);
}

TEST(ParallelChunks, GivesNoChunkLargerThanTheGrainToManyThreads)
{
    std::atomic<std::size_t> largest{0};
    parallel_chunks(1000, 16, 2, [&](std::size_t begin, std::size_t end, int) {
        std::size_t seen = largest;
        while (end - begin > seen && !largest.compare_exchange_weak(seen, end - begin)) {}
    });
    EXPECT_EQ(largest, 16u);
}

TEST(ParallelChunks, NeverGivesOneThreadNumberToTwoThreadsAtATime)
{
    std::vector<std::atomic<int>> busy(8);
    std::atomic<bool> clash{false};
    parallel_chunks(20000, 1, 8, [&](std::size_t, std::size_t, int thread) {
        if (++busy[std::size_t(thread)] != 1) clash = true;
        --busy[std::size_t(thread)];
    });
    EXPECT_FALSE(clash);
}

TEST(ParallelChunks, HandsTheWorkersWritesOverToTheCaller)
{
    std::vector<std::size_t> results(100000);
    parallel_chunks(results.size(), 100, 4, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) results[i] = i * i;
    });
    for (std::size_t i = 0; i < results.size(); ++i) ASSERT_EQ(results[i], i * i);
}

TEST(ParallelChunks, MayBeCalledFromInsideAnother)
{
    std::atomic<int> items{0};
    parallel_chunks(4, 1, 2, [&](std::size_t, std::size_t, int) {
        parallel_chunks(10, 1, 2, [&](std::size_t begin, std::size_t end, int) { items += int(end - begin); });
    });
    EXPECT_EQ(items, 40);
}

TEST(HardwareThreads, IsAtLeastOne)
{
    EXPECT_GE(hardware_threads(), 1);
}

} // namespace
} // namespace oncollide
