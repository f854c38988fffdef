#pragma once
#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include <oncollide/scenes/files/json/json_tape.hpp>

namespace oncollide {

// JSON values with their place in the file, for messages. Private to scenes.

/// A value and its place. The accessors throw Error{bad_data} `file: place: the fault and the expected value`. Valid as
/// long as the tape keeps its text.
class Node {
public:
    /// The root.
    explicit Node(const JsonTape& tape) : tape_(&tape), at_(0) {}

    std::string place() const; ///< "scene.json: bodies[3].motion"
    [[noreturn]] void fail(const std::string& what) const;

    bool is_object() const { return value().kind == JsonValue::Kind::object; }
    bool is_array() const { return value().kind == JsonValue::Kind::array; }
    bool is_number() const { return value().is_number(); }
    bool is_text() const { return value().kind == JsonValue::Kind::text; }
    std::string_view source() const { return value().source_text(); } ///< its bytes in the file

    /// Throws unless the value is an object with no keys other than these.
    void only(std::initializer_list<std::string_view> keys) const;
    /// The same, but returns the members in the order of the keys, which are literals; a missing member is empty.
    template <class... Keys>
    std::array<std::optional<Node>, sizeof...(Keys)> members(const Keys&... keys) const;
    /// Throws unless the value is an object with exactly one key, one of these; returns it.
    std::string_view one_of(std::initializer_list<std::string_view> keys) const;
    bool has(std::string_view key) const { return find(key) != 0; }
    Node operator[](std::string_view key) const; ///< a member that must exist
    Node operator[](std::size_t i) const;        ///< an element; linear cost: iterate over long arrays
    std::size_t size() const;                    ///< size of an array
    std::string_view key() const { return tape_->values()[at_ - 1].as_text(); } ///< the member's key

    double number() const;
    double number(std::string_view key, double otherwise) const; ///< the number of a member that may be missing
    double positive(std::string_view key, double otherwise) const;
    std::int64_t integer(std::int64_t least, std::int64_t most) const;
    std::uint64_t natural() const; ///< 0 to 2^64 - 1
    std::string_view text() const; ///< valid as long as the tape's text
    bool boolean() const;
    Eigen::Vector3d vector3() const;
    /// Throws unless the value is an array of exactly `count` numbers; writes them to `out`.
    void numbers(std::size_t count, double* out) const;
    bool holds_numbers(std::size_t count) const;

    /// The elements of an array or the members of an object; empty for other values.
    class Iterator;
    Iterator begin() const;
    Iterator end() const;

private:
    Node(const Node& other, std::uint32_t at) : tape_(other.tape_), at_(at) {}
    const JsonValue& value() const { return tape_->values()[at_]; }
    std::uint32_t find(std::string_view key) const; ///< 0: not found
    void must_be(bool right, std::string_view what) const;
    std::string excerpt() const; ///< excerpt of source(), on one line

    const JsonTape* tape_;
    std::uint32_t at_; ///< index on the tape
};

class Node::Iterator {
public:
    Iterator(const Node& of, std::uint32_t at) : of_(&of), at_(at) {}
    Node operator*() const { return {*of_, value()}; }
    Iterator& operator++()
    {
        at_ = of_->tape_->values()[value()].end;
        return *this;
    }
    friend bool operator==(const Iterator& a, const Iterator& b) { return a.at_ == b.at_; }

private:
    std::uint32_t value() const { return at_ + of_->is_object(); } // index of the value, after its key

    const Node* of_;
    std::uint32_t at_;
};

template <class... Keys>
std::array<std::optional<Node>, sizeof...(Keys)> Node::members(const Keys&... keys) const
{
    std::array<std::optional<Node>, sizeof...(Keys)> found;
    if (!is_object()) only({keys...}); // always throws
    for (const Node member : *this) {
        const std::string_view key = member.key();
        std::size_t i = 0;
        if (!((key == std::string_view(keys, sizeof keys - 1) || (++i, false)) || ...)) only({keys...});
        found[i] = member;
    }
    return found;
}

} // namespace oncollide
