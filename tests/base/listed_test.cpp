#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/near_word.hpp>

namespace oncollide {
namespace {

TEST(Listed, LongNamesKeepBothEnds)
{
    EXPECT_EQ(shortened("bolt", 10), "bolt");
    EXPECT_EQ(shortened("0123456789", 10), "0123456789");
    EXPECT_EQ(shortened("0123456789a", 10), "01234...9a");
    EXPECT_EQ(shortened(std::string(1'000'000, 'x')).size(), most_of_a_name);
    std::string umlauts;
    for (int k = 0; k < 100; ++k) umlauts += "\xc3\xa4";
    for (std::size_t most = 10; most < 20; ++most) {
        const std::string text = shortened(umlauts, most);
        EXPECT_LE(text.size(), most);
        const std::size_t gap = text.find("...");
        EXPECT_EQ(gap % 2, 0u) << "no character is cut: " << text;
        EXPECT_EQ((text.size() - gap - 3) % 2, 0u) << text;
    }
}

TEST(Listed, LongListsEndWithTheNumberLeftOut)
{
    EXPECT_EQ(listed(std::vector<std::string>{"kd", "octree"}), "kd, octree");
    EXPECT_EQ(listed(std::vector<std::string>{}), "");
    const std::vector<std::string> names(500, std::string(1000, 'n'));
    const std::string text = listed(names);
    EXPECT_LE(text.size(), most_of_a_list + most_of_a_name + 20);
    EXPECT_TRUE(text.ends_with(", and 485 more")) << text.substr(text.size() - 30);
    const std::vector<std::string_view> views(names.begin(), names.end());
    EXPECT_LE(valid_names("x", views).size(), 2000u);
}

TEST(Listed, NoMessageOfAnErrorIsEndless)
{
    const Error error(ErrorKind::bad_data, "a.obj: " + std::string(1'000'000, 'x') + ": the cure");
    const std::string_view what = error.what();
    EXPECT_EQ(what.size(), most_of_a_message);
    EXPECT_TRUE(what.starts_with("a.obj: x") && what.ends_with("x: the cure"));
}

} // namespace
} // namespace oncollide
