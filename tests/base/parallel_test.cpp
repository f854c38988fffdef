#include <atomic>
#include <barrier>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <oncollide/base/executor.hpp>
#include <oncollide/base/threads/parallel.hpp>

#ifndef _WIN32
#include <sys/wait.h>
#include <unistd.h>
#endif

namespace oncollide {
namespace {

/// An executor as an application may write it: one thread after the other, the last task first.
class OneAfterTheOther final : public Executor {
public:
    int threads() const override { return 1; }
    void run(int tasks, const std::function<void(int)>& work) override
    {
        while (tasks--) std::thread([&] { work(tasks); }).join();
    }
};

Executor& named(std::string_view name)
{
    static OneAfterTheOther one_after_the_other;
    if (name == "OneAfterTheOther") return one_after_the_other;
    return name == "OpenMp" ? openmp_executor() : thread_pool();
}

/// Every executor satisfies the contract of parallel_chunks.
class ParallelChunks : public testing::TestWithParam<const char*> {
    ExecutorScope scope_{&named(GetParam())};
};

TEST_P(ParallelChunks, CoversEveryItemOnceForAnyCountGrainAndThreads)
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

TEST_P(ParallelChunks, DoesNothingForNoItems)
{
    bool called = false;
    parallel_chunks(0, 10, 4, [&](std::size_t, std::size_t, int) { called = true; });
    EXPECT_FALSE(called);
}

TEST_P(ParallelChunks, GivesNoChunkLargerThanTheGrainToManyThreads)
{
    std::atomic<std::size_t> largest{0};
    parallel_chunks(1000, 16, 2, [&](std::size_t begin, std::size_t end, int) {
        std::size_t seen = largest;
        while (end - begin > seen && !largest.compare_exchange_weak(seen, end - begin)) {}
    });
    EXPECT_EQ(largest, 16u);
}

TEST_P(ParallelChunks, NeverGivesOneThreadNumberToTwoThreadsAtATime)
{
    std::vector<std::atomic<int>> busy(8);
    std::atomic<bool> clash{false};
    parallel_chunks(20000, 1, 8, [&](std::size_t, std::size_t, int thread) {
        if (++busy[std::size_t(thread)] != 1) clash = true;
        --busy[std::size_t(thread)];
    });
    EXPECT_FALSE(clash);
}

TEST_P(ParallelChunks, HandsTheWorkersWritesOverToTheCaller)
{
    std::vector<std::size_t> results(100000);
    parallel_chunks(results.size(), 100, 4, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) results[i] = i * i;
    });
    for (std::size_t i = 0; i < results.size(); ++i) ASSERT_EQ(results[i], i * i);
}

TEST_P(ParallelChunks, MayBeCalledFromInsideAnother)
{
    std::atomic<int> items{0};
    parallel_chunks(4, 1, 2, [&](std::size_t, std::size_t, int) {
        parallel_chunks(10, 1, 2, [&](std::size_t begin, std::size_t end, int) { items += int(end - begin); });
    });
    EXPECT_EQ(items, 40);
}

#ifdef ONCOLLIDE_OPENMP
INSTANTIATE_TEST_SUITE_P(Every, ParallelChunks, testing::Values("ThreadPool", "OpenMp", "OneAfterTheOther"),
                         [](const auto& way) { return std::string(way.param); });
#else
INSTANTIATE_TEST_SUITE_P(Every, ParallelChunks, testing::Values("ThreadPool", "OneAfterTheOther"),
                         [](const auto& way) { return std::string(way.param); });
#endif

std::size_t sum_in_parallel(std::size_t count, int threads)
{
    std::vector<std::size_t> sums(static_cast<std::size_t>(threads));
    parallel_chunks(count, 1, threads, [&](std::size_t begin, std::size_t end, int thread) {
        for (std::size_t i = begin; i < end; ++i) sums[static_cast<std::size_t>(thread)] += i;
    });
    std::size_t sum = 0;
    for (const std::size_t part : sums) sum += part;
    return sum;
}

TEST(ThreadPool, RunsItsTasksAtTheSameTime)
{
    std::barrier together(3); // a single thread would wait forever
    thread_pool().run(3, [&](int) { together.arrive_and_wait(); });
}

TEST(ThreadPool, ServesManyThreadsAtOnce)
{
    std::atomic<int> wrong{0};
    std::vector<std::thread> users;
    for (int user = 0; user < 6; ++user)
        users.emplace_back([&] {
            for (int loop = 0; loop < 500; ++loop)
                if (sum_in_parallel(64, 4) != 64 * 63 / 2) ++wrong;
        });
    for (std::thread& user : users) user.join();
    EXPECT_EQ(wrong, 0);
}

#if !defined(__SANITIZE_THREAD__) && !defined(_WIN32) // its runtime does not start threads after a fork
TEST(ThreadPool, WorksInAForkedProcess)
{
    ASSERT_EQ(sum_in_parallel(64, 4), 64u * 63 / 2); // the parent's threads exist
    const pid_t child = fork();
    if (child == 0) _exit(sum_in_parallel(64, 4) == 64 * 63 / 2 ? 0 : 1);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}
#endif

TEST(ExecutorScope, HoldsForItsThreadUntilItEnds)
{
    OneAfterTheOther mine, inner;
    EXPECT_EQ(&current_executor(), &thread_pool());
    {
        const ExecutorScope scope(&mine);
        EXPECT_EQ(&current_executor(), &mine);
        {
            const ExecutorScope nested(&inner);
            EXPECT_EQ(&current_executor(), &inner);
        }
        EXPECT_EQ(&current_executor(), &mine);
        std::thread([] { EXPECT_EQ(&current_executor(), &thread_pool()); }).join();
    }
    EXPECT_EQ(&current_executor(), &thread_pool());
}

TEST(HardwareThreads, IsAtLeastOne)
{
    EXPECT_GE(hardware_threads(), 1);
}

} // namespace
} // namespace oncollide
