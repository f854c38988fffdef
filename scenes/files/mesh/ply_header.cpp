#include <oncollide/scenes/files/mesh/ply_header.hpp>

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace oncollide::ply {

namespace {

constexpr std::array<std::array<const char*, 2>, 8> type_names = {{{"char", "int8"},
                                                                   {"uchar", "uint8"},
                                                                   {"short", "int16"},
                                                                   {"ushort", "uint16"},
                                                                   {"int", "int32"},
                                                                   {"uint", "uint32"},
                                                                   {"float", "float32"},
                                                                   {"double", "float64"}}};

/// Parses the header line by line; PLY's comments are statements, so TextReader does not fit.
class HeaderParser {
public:
    explicit HeaderParser(const MeshSource& source)
        : source_(source), at_(source.bytes.size() - without_byte_order_mark(source.bytes).size()),
          line_end_(source.bytes.substr(at_).starts_with("ply\r") && !source.bytes.substr(at_).starts_with("ply\r\n")
                        ? '\r' // as on old Macs
                        : '\n')
    {
    }

    Header parse_header()
    {
        if (next_line(); word() != "ply") source_.fail("the file does not begin with 'ply'", 1);
        bool has_format = false;
        for (;;) {
            next_line();
            const std::string_view keyword = word();
            if (keyword == "end_header") break;
            if (keyword == "format") {
                read_format(), has_format = true;
            } else if (keyword == "element") {
                read_element();
            } else if (keyword == "property") {
                read_property();
            } else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
                fail(fmt::format("unknown header line {}; known are format, element, property, comment, end_header",
                                 oncollide::quoted(keyword)));
            }
        }
        if (!has_format) fail("the header names no format");
        for (const Element& element : header_.elements)
            if (element.properties.empty() && element.count > 0)
                fail(fmt::format("element {} has no properties", oncollide::quoted(element.name)));
        header_.bytes = at_, header_.lines = line_;
        return std::move(header_);
    }

private:
    [[noreturn]] void fail(const std::string& what) const { source_.fail(what, line_); }

    void next_line()
    {
        ++line_;
        const std::size_t end = source_.bytes.find(line_end_, at_);
        if (end == source_.bytes.npos) fail("the file ends within the header");
        words_ = source_.bytes.substr(at_, end - at_);
        at_ = end + 1;
    }

    std::string_view word()
    {
        constexpr std::string_view blank = " \t\r";
        const std::size_t begin = std::min(words_.find_first_not_of(blank), words_.size());
        const std::size_t end = std::min(words_.find_first_of(blank, begin), words_.size());
        const std::string_view found = words_.substr(begin, end - begin);
        words_ = words_.substr(end);
        return found;
    }

    void read_format()
    {
        const std::string_view name = word();
        if (name == "ascii")
            header_.encoding = Encoding::text;
        else if (name == "binary_little_endian")
            header_.encoding = Encoding::little_endian;
        else if (name == "binary_big_endian")
            header_.encoding = Encoding::big_endian;
        else
            fail(fmt::format("unknown format {}; known are ascii, binary_little_endian, binary_big_endian",
                             oncollide::quoted(name)));
    }

    void read_element()
    {
        Element element{std::string(word()), 0, {}};
        const std::string_view count = word();
        if (!parse(count, element.count) || element.count < 0)
            fail(fmt::format("the number of element {} is {}", oncollide::quoted(element.name),
                             oncollide::quoted(count)));
        if (static_cast<std::uint64_t>(element.count) > source_.bytes.size())
            fail(fmt::format("a file of {} bytes cannot hold {} of element {}", source_.bytes.size(), element.count,
                             oncollide::quoted(element.name)));
        header_.elements.push_back(std::move(element));
    }

    Type type_named(std::string_view name) const
    {
        for (std::size_t i = 0; i < type_names.size(); ++i)
            if (name == type_names[i][0] || name == type_names[i][1]) return static_cast<Type>(i);
        fail(fmt::format("unknown type {}; known are char, uchar, short, ushort, int, uint, float, double",
                         oncollide::quoted(name)));
    }

    void read_property()
    {
        if (header_.elements.empty()) fail("a property stands before the first element");
        Property property{};
        std::string_view type = word();
        if (type == "list") {
            property.list = type_named(word());
            if (*property.list >= Type::float32) fail("the length of a list must have a whole-number type");
            type = word();
        }
        property.type = type_named(type);
        property.name = word();
        header_.elements.back().properties.push_back(std::move(property));
    }

    const MeshSource& source_;
    std::string_view words_;
    std::size_t at_, line_ = 0;
    const char line_end_;
    Header header_;
};

} // namespace

Header read_header(const MeshSource& source)
{
    return HeaderParser(source).parse_header();
}

} // namespace oncollide::ply
