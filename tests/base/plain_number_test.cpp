#include <gtest/gtest.h>

#include <limits>

#include <oncollide/base/text/plain_number.hpp>

namespace oncollide {
namespace {

TEST(PlainNumber, IsWrittenAsPeopleWriteIt)
{
    EXPECT_EQ(plain_number(0, 4), "0");
    EXPECT_EQ(plain_number(-0.0, 4), "0");
    EXPECT_EQ(plain_number(0.025, 4), "0.025");
    EXPECT_EQ(plain_number(1.0 / 3, 4), "0.3333");
    EXPECT_EQ(plain_number(12.5, 4), "12.5");
    EXPECT_EQ(plain_number(9080, 4), "9080");
    EXPECT_EQ(plain_number(1e4, 4), "10000");
    EXPECT_EQ(plain_number(12345.6, 4), "12346") << "digits before the point are never dropped";
    EXPECT_EQ(plain_number(-12345.6, 6), "-12345.6");
    EXPECT_EQ(plain_number(100, 4), "100") << "zeros before the point stay";
    EXPECT_EQ(plain_number(999.996, 4), "1000");
    EXPECT_EQ(plain_number(0.00012345, 3), "0.000123");
    EXPECT_EQ(plain_number(7e-12, 4), "7e-12");
    EXPECT_EQ(plain_number(1e300, 4), "1e+300");
    EXPECT_EQ(plain_number(std::numeric_limits<double>::infinity(), 4), "inf");
    EXPECT_EQ(plain_number(1e14, 4), "100000000000000");
}

TEST(PlainNumber, MeasuresHaveGroupsFromTenThousandOn)
{
    EXPECT_EQ(plain_measure(9080, 4), "9080");
    EXPECT_EQ(plain_measure(1e4, 4), "10,000");
    EXPECT_EQ(plain_measure(-1234567.5, 8), "-1,234,567.5");
    EXPECT_EQ(plain_measure(123456, 4), "123,456");
    EXPECT_EQ(plain_measure(0.000123456, 6), "0.000123456") << "no groups behind the point";
    EXPECT_EQ(plain_measure(1e20, 4), "1e+20");
}

} // namespace
} // namespace oncollide
