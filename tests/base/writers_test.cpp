// Text that other programs parse: JSON, CSV and XML, with names that contain their syntax.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <oncollide/base/text/csv_reader.hpp>
#include <oncollide/base/text/csv_writer.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/base/text/svg.hpp>
#include <oncollide/base/utf8.hpp>

namespace oncollide {
namespace {

TEST(Utf8, InvalidBytesAreReplacedAsUnicodeRecommends)
{
    EXPECT_EQ(as_utf8("a\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80"), "a\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80");
    const std::string r = "\xef\xbf\xbd";
    EXPECT_EQ(as_utf8("\xff|\xc3|\xe2\x82|\xf0\x9f\x98"), r + "|" + r + "|" + r + "|" + r);
    EXPECT_EQ(as_utf8("\xc0\x80|\xed\xa0\x80|\xf4\x90"), r + r + "|" + r + r + r + "|" + r + r);
}

TEST(JsonWriter, WritesCommasLinesAndNestedValues)
{
    TextInMemory text;
    JsonWriter json(text);
    json.begin_object();
    json.key("header"), json.object("a", 1, "b", true, "c", nullptr, "d", std::optional<int>(), "e", "x");
    json.line(), json.key("rows"), json.begin_array();
    for (int k = 0; k < 2; ++k) json.line(2), json.array(k, "y", [&] { json.array(0.5); });
    json.line(), json.end_array();
    json.key("none"), json.begin_array(), json.end_array();
    json.members("raw", JsonText{"[1]"}, "n", Fixed{1, 3}, "h", Hex{255});
    json.end_object();
    EXPECT_EQ(text.text(), "{\"header\": {\"a\": 1, \"b\": true, \"c\": null, \"d\": null, \"e\": \"x\"},\n"
                           "\"rows\": [\n  [0, \"y\", [0.5]],\n  [1, \"y\", [0.5]]\n], \"none\": [], \"raw\": [1], "
                           "\"n\": 1.000, \"h\": \"00000000000000ff\"}");
}

TEST(JsonWriter, GoesOnWithinWhatAnotherHasBegun)
{
    TextInMemory text;
    JsonWriter json = JsonWriter::within(text);
    json.line(), json.value(1), json.value(2);
    EXPECT_EQ(text.text(), ",\n1, 2");
}

TEST(JsonWriter, EscapesTextAndHasNoNumberThatJsonLacks)
{
    EXPECT_EQ(json_string("\"\\/\b\f\n\r\t\x01\x1f\x7f\xc3\xa4\xff"),
              "\"\\\"\\\\/\\b\\f\\n\\r\\t\\u0001\\u001f\x7f\xc3\xa4\xef\xbf\xbd\"");
    TextInMemory text;
    JsonWriter json(text);
    const double infinity = std::numeric_limits<double>::infinity();
    json.array(infinity, -infinity, std::nan(""), Fixed{infinity, 2}, 0.1, 1.0, 1e300, -1, std::uint64_t(-1));
    EXPECT_EQ(text.text(), "[null, null, null, null, 0.1, 1, 1e+300, -1, 18446744073709551615]");
}

TEST(CsvWriter, QuotesWhatNeedsQuotes)
{
    TextInMemory text;
    CsvWriter csv(text, "a,b,c");
    csv.row("plain text", "a,b", "say \"so\"");
    csv.row("two\nlines", Quoted{"q"}, "\xff");
    csv.row(1.5, std::nullopt, true);
    csv.row(Fixed{1, 2}, Digits{1.0 / 3, 3}, Hex{1});
    EXPECT_EQ(text.text(), "a,b,c\nplain text,\"a,b\",\"say \"\"so\"\"\"\n\"two\nlines\",\"q\",\xef\xbf\xbd\n"
                           "1.5,,1\n1.00,0.333,0000000000000001\n");
    EXPECT_THROW(csv.row(1, 2), Error);
}

using Rows = std::vector<std::vector<std::string>>;

Rows rows_of(const std::string& text, CsvReader::Style style)
{
    const std::string file = "f.csv";
    Rows rows;
    for (CsvReader csv(file, text, style); !csv.at_end(); csv.next_line()) {
        rows.emplace_back();
        for (bool last = false; !last;) rows.back().emplace_back(csv.next(last));
    }
    return rows;
}

TEST(CsvWriter, NoTextIsAFormulaOfASpreadsheet)
{
    for (const std::string formula : {"=1+2", "+1", "-arm", "@sum", "\tx", "\rx"}) {
        EXPECT_EQ(csv_text(rows_of(csv_field(formula) + "\n", CsvReader::Style::table)[0][0]), formula);
        EXPECT_EQ(csv_field(formula, true), "\"'" + formula + "\"");
        TextInMemory text;
        CsvWriter(text).row(formula, Quoted{formula}, formula.c_str(), std::string_view(formula));
        EXPECT_EQ(text.text().find(formula[0]), text.text().find('\'') + 1) << text.text();
    }
    for (const std::string plain : {"a=1", "'quoted'", "", "1-2", "(=x)"}) EXPECT_EQ(csv_field(plain), plain);
    TextInMemory numbers;
    CsvWriter(numbers).row(-1, -0.5, Digits{-2, 3}, Fixed{-3, 1});
    EXPECT_EQ(numbers.text(), "-1,-0.5,-2,-3.0\n") << "numbers stay numbers";
    EXPECT_EQ(csv_text("'plain"), "'plain");
}

TEST(CsvReader, ReadsTablesStrictly)
{
    const auto read = [](const std::string& text) { return rows_of(text, CsvReader::Style::table); };
    EXPECT_EQ(read("a,b\r\n1,\"x, \"\"y\"\"\"\r\n,"), (Rows{{"a", "b"}, {"1", "x, \"y\""}, {"", ""}}));
    EXPECT_EQ(read(" a ,#b\n"), (Rows{{" a ", "#b"}}));
    for (const char* wrong : {"\"a", "\"a\nb\"\n", "\"a\"b\n"}) EXPECT_THROW(read(wrong), Error) << wrong;
}

TEST(CsvReader, ReadsListsOfPeople)
{
    const auto read = [](const std::string& text) { return rows_of(text, CsvReader::Style::list); };
    EXPECT_EQ(read("# heading\n\n \"a b\" , c d # why, so\n\" e \",#f\n"),
              (Rows{{""}, {""}, {"a b", "c d"}, {" e ", "#f"}}));
    EXPECT_EQ(read("\"two\nlines\",b\r\n"), (Rows{{"two\nlines", "b"}}));
    for (const char* wrong : {"\"a", "\"a\" b\n"}) EXPECT_THROW(read(wrong), Error) << wrong;
    try {
        read("a\n\"b\nc\n");
        ADD_FAILURE() << "a quote is not closed";
    } catch (const Error& error) {
        EXPECT_STREQ(error.what(), "f.csv: line 2: a quoted field has no closing quote");
    }
}

TEST(CsvReader, ReadsBackWhatTheWriterWrote)
{
    const std::string names[] = {"a\"b", "a,b", "a\r\nb", "\"", "", "\xc3\xa4", " #x "};
    TextInMemory text;
    CsvWriter csv(text);
    for (const std::string& name : names) csv.row(Quoted{name}, name);
    const Rows rows = rows_of(text.text(), CsvReader::Style::list);
    ASSERT_EQ(rows.size(), std::size(names));
    for (std::size_t k = 0; k < rows.size(); ++k) EXPECT_EQ(rows[k][0], names[k]);
}

TEST(Svg, TextEndsNoElementAndNoAttribute)
{
    EXPECT_EQ(xml_escaped("<a href=\"x\">&\n\xff"), "&lt;a href=&quot;x&quot;&gt;&amp;\\x0a\\xff");
}

} // namespace
} // namespace oncollide
