#include <oncollide/narrowphase/pairs/manifolds/key_numbers.hpp>

#include <map>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>

namespace oncollide::key_numbers_test {
namespace {

TEST(KeyNumbers, NumberKeysInTheOrderOfTheirFirstUse)
{
    KeyNumbers numbers;
    for (std::uint64_t use = 0; use < 4; ++use) { // the memory is kept
        numbers.clear();
        std::map<std::uint64_t, std::uint32_t> truth;
        for (std::uint64_t i = 0; i < 3000; ++i) {
            // Few of many keys, also such as differ in the highest bits alone, and 0.
            const std::uint64_t draw = std::uint64_t(700 * u01(use, i, 0)), key = i % 2 ? draw : draw << 54;
            bool is_new;
            const std::uint32_t number = numbers.add(key, is_new);
            const auto [at, added] = truth.emplace(key, std::uint32_t(truth.size()));
            ASSERT_EQ(is_new, added);
            ASSERT_EQ(number, at->second);
        }
        EXPECT_EQ(numbers.count(), truth.size());
        for (const auto& [key, number] : truth) EXPECT_EQ(numbers.find(key), number);
        EXPECT_EQ(numbers.find(701), KeyNumbers::none);
    }
}

} // namespace
} // namespace oncollide::key_numbers_test
