#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include <oncollide/base/memory/once.hpp>

namespace oncollide::once_test {
namespace {

TEST(Once, IsMadeByOneThreadAndSeenByAll)
{
    for (int round = 0; round < 300; ++round) {
        const Once<std::vector<int>> once;
        std::atomic<int> made = 0;
        std::vector<std::thread> threads;
        std::vector<const std::vector<int>*> seen(8);
        EXPECT_EQ(once.made(), nullptr);
        for (std::size_t i = 0; i < seen.size(); ++i)
            threads.emplace_back([&, i] {
                seen[i] = &once.get([&] {
                    ++made;
                    return std::vector<int>{1, 2, 3};
                });
                EXPECT_EQ(*seen[i], (std::vector<int>{1, 2, 3}));
            });
        for (std::thread& thread : threads) thread.join();
        EXPECT_EQ(made, 1);
        for (const auto* value : seen) EXPECT_EQ(value, once.made());
    }
}

TEST(Once, TriesAgainAfterAnException)
{
    const Once<int> once;
    EXPECT_THROW(once.get([]() -> int { throw std::runtime_error("no room"); }), std::runtime_error);
    EXPECT_EQ(once.made(), nullptr);
    EXPECT_EQ(once.get([] { return 7; }), 7);
    EXPECT_EQ(once.get([] { return 8; }), 7);
}

TEST(Once, IsMadeAgainAfterReset)
{
    Once<int> once;
    once.reset();
    EXPECT_EQ(once.get([] { return 7; }), 7);
    once.reset();
    EXPECT_EQ(once.made(), nullptr);
    EXPECT_EQ(once.get([] { return 8; }), 8);
}

} // namespace
} // namespace oncollide::once_test
