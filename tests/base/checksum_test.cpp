#include <gtest/gtest.h>

#include <oncollide/base/files/checksum.hpp>
#include <oncollide/base/memory/lazy_memory.hpp>

namespace oncollide {
namespace {

/// Values computed by other programs.
TEST(Checksum, IsXxh64)
{
    EXPECT_EQ(checksum(""), 0xef46db3751d8e999u);
    EXPECT_EQ(checksum("a"), 0xd24ec4f1a98c6e5bu);
    EXPECT_EQ(checksum("abc"), 0x44bc2cf5ad770999u);
    EXPECT_EQ(checksum("Nobody inspects the spammish repetition"), 0xfbcea83c8a378bf1u);
}

TEST(Checksum, IsLookup3)
{
    EXPECT_EQ(lookup3(""), 0xdeadbeefu);
    EXPECT_EQ(lookup3("Four score and seven years ago"), 0x17770551u); // of its source
}

TEST(LazyMemory, IsZeroUntilWrittenAndOnceGivenBack)
{
    LazyMemory memory(std::size_t(1) << 36); // more than the machine has
    std::byte* const bytes = memory.data();
    const std::size_t at = std::size_t(1) << 35, size = 3 * LazyMemory::page;
    EXPECT_EQ(bytes[at], std::byte{});
    for (std::size_t i = 0; i < size; ++i) bytes[at + i] = std::byte{7};
    memory.give_back(at, LazyMemory::page + 1);
    EXPECT_EQ(bytes[at], std::byte{});
    EXPECT_EQ(bytes[at + LazyMemory::page], std::byte{});
    EXPECT_EQ(bytes[at + 2 * LazyMemory::page], std::byte{7});
}

} // namespace
} // namespace oncollide
