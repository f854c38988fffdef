#include <oncollide/scenes/files/json/json_node.hpp>

#include <algorithm>
#include <limits>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/text/near_word.hpp>

namespace oncollide {

using Kind = JsonValue::Kind;

namespace {

std::string_view name_of(Kind kind)
{
    switch (kind) {
    case Kind::null:
        return "null";
    case Kind::boolean:
        return "boolean";
    case Kind::text:
        return "string";
    case Kind::array:
        return "array";
    case Kind::object:
        return "object";
    default:
        return "number";
    }
}

} // namespace

std::string Node::place() const
{
    const std::vector<JsonValue>& values = tape_->values();
    std::string path;
    for (std::uint32_t at = at_; at != 0; at = values[at].parent) {
        const std::uint32_t parent = values[at].parent;
        std::string step;
        if (values[parent].kind == Kind::object) {
            step = fmt::format(".{}", values[at - 1].as_text());
        } else {
            std::size_t i = 0;
            for (std::uint32_t other = parent + 1; other != at; other = values[other].end) ++i;
            step = fmt::format("[{}]", i);
        }
        path = step + path;
    }
    const JsonPlace& root = tape_->place;
    if (!root.list.empty())
        path = fmt::format("{}[{}]{}", root.list, root.number, path);
    else if (path.starts_with('.'))
        path.erase(0, 1);
    return path.empty() ? std::string(root.file) : fmt::format("{}: {}", root.file, path);
}

void Node::fail(const std::string& what) const
{
    throw Error(ErrorKind::bad_data, fmt::format("{}: {}", place(), what));
}

void Node::must_be(bool right, std::string_view what) const
{
    if (!right)
        fail(fmt::format("is {} {}, must be {}", is_array() || is_object() ? "an" : "a", name_of(value().kind), what));
}

std::string Node::excerpt() const
{
    constexpr std::size_t most = 60;
    std::string text(source().substr(0, 10 * most));
    std::erase_if(text, [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; });
    return text.size() > most ? text.substr(0, most - 3) + "..." : text;
}

void Node::only(std::initializer_list<std::string_view> keys) const
{
    if (!is_object()) must_be(false, fmt::format("an object with keys among: {}", fmt::join(keys, ", ")));
    for (const Node& member : *this)
        if (std::find(keys.begin(), keys.end(), member.key()) == keys.end())
            member.fail("unknown key" + valid_names(member.key(), keys));
}

std::string_view Node::one_of(std::initializer_list<std::string_view> keys) const
{
    only(keys);
    if (value().size != 1)
        fail(fmt::format("has {} keys, must have exactly one of: {}", value().size, fmt::join(keys, ", ")));
    return (*begin()).key();
}

std::uint32_t Node::find(std::string_view key) const
{
    if (!is_object()) return 0;
    for (const Node& member : *this)
        if (member.key() == key) return member.at_;
    return 0;
}

Node Node::operator[](std::string_view key) const
{
    const std::uint32_t found = find(key);
    if (found == 0) fail(fmt::format("the key '{}' is missing", key));
    return {*this, found};
}

Node Node::operator[](std::size_t i) const
{
    Iterator element = begin();
    while (i-- > 0) ++element;
    return *element;
}

std::size_t Node::size() const
{
    must_be(is_array(), "an array");
    return value().size;
}

Node::Iterator Node::begin() const
{
    return {*this, std::min(at_ + 1, value().end)};
}

Node::Iterator Node::end() const
{
    return {*this, value().end};
}

double Node::number() const
{
    must_be(is_number(), "a number");
    return value().as_number();
}

double Node::number(std::string_view key, double otherwise) const
{
    return has(key) ? (*this)[key].number() : otherwise;
}

double Node::positive(std::string_view key, double otherwise) const
{
    const double number = this->number(key, otherwise);
    if (has(key) && !(number > 0)) (*this)[key].fail(fmt::format("is {}, must be above 0", number));
    return number;
}

std::int64_t Node::integer(std::int64_t least, std::int64_t most) const
{
    constexpr auto largest = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
    const JsonValue& v = value();
    if (v.kind == Kind::negative && v.negative >= least && v.negative <= most) return v.negative;
    if (v.kind == Kind::natural && v.natural <= largest) {
        const auto natural = static_cast<std::int64_t>(v.natural);
        if (natural >= least && natural <= most) return natural;
    }
    const std::string range = fmt::format("a whole number from {} to {}", least, most);
    must_be(is_number(), range);
    fail(fmt::format("is {}, must be {}", excerpt(), range));
}

std::uint64_t Node::natural() const
{
    constexpr std::string_view range = "a whole number from 0 to 2^64 - 1";
    must_be(is_number(), range);
    if (value().kind != Kind::natural) fail(fmt::format("is {}, must be {}", excerpt(), range));
    return value().natural;
}

std::string_view Node::text() const
{
    must_be(is_text(), "a text");
    return value().as_text();
}

bool Node::boolean() const
{
    must_be(value().kind == Kind::boolean, "true or false");
    return value().truth;
}

Eigen::Vector3d Node::vector3() const
{
    Eigen::Vector3d v;
    numbers(3, v.data());
    return v;
}

bool Node::holds_numbers(std::size_t count) const
{
    if (!is_array() || value().size != count || value().end != at_ + 1 + count) return false;
    const std::span elements = std::span(tape_->values()).subspan(at_ + 1, count);
    return std::ranges::all_of(elements, &JsonValue::is_number);
}

void Node::numbers(std::size_t count, double* out) const
{
    if (!holds_numbers(count)) fail(fmt::format("is {}, must be an array of {} numbers", excerpt(), count));
    for (std::size_t i = 1; i <= count; ++i) *out++ = tape_->values()[at_ + i].as_number();
}

} // namespace oncollide
