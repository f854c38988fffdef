#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <shared_mutex>
#include <thread>
#include <vector>

#include <oncollide/base/threads/lock_order.hpp>

namespace oncollide::shared_mutex_test {
namespace {

TEST(SharedMutex, ReadersSeeWhatAWriterHasWrittenWhole)
{
    SharedMutex mutex;
    int first = 0, second = 0;
    std::atomic<int> torn = 0;
    std::vector<std::thread> threads;
    for (int i = 0; i < 8; ++i)
        threads.emplace_back([&, i] {
            for (int round = 0; round < 20000; ++round) {
                if (i < 2) {
                    const std::unique_lock lock(mutex);
                    ++first, ++second;
                } else {
                    const std::shared_lock lock(mutex);
                    torn += first != second;
                }
            }
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(torn, 0);
    EXPECT_EQ(first, 40000);
    EXPECT_EQ(second, 40000);
}

} // namespace
} // namespace oncollide::shared_mutex_test
