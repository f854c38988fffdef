#pragma once
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

namespace oncollide {

// Reading JSON so that every complaint names its place. Private to scenes.

using Json = nlohmann::json;

struct JsonFile {
    Json root;
    std::vector<std::string> geometries; ///< the keys of the top member "geometries" in the file's order
};

/// Parses `text`. Throws Error{bad_data}, the message beginning with `file`: syntax errors with line and column,
/// numbers too large for a double, a key given twice in one object, more than 32 levels of nesting.
JsonFile parse_json(const std::string& file, const std::string& text);

/// A value and where it stands. The accessors throw Error{bad_data} `file: place: what is wrong and what would be
/// right`.
class Node {
public:
    /// The root. `value` and `file` must outlive every node.
    Node(const Json& value, std::string_view file) : value_(&value), file_(file) {}

    const Json& json() const { return *value_; }
    std::string place() const; ///< "scene.json: bodies[3].motion"
    [[noreturn]] void fail(const std::string& what) const;

    /// The value is an object without other keys than these.
    void only(std::initializer_list<std::string_view> keys) const;
    /// The value is an object with exactly one key, one of these; returns it.
    std::string one_of(std::initializer_list<std::string_view> keys) const;
    bool has(std::string_view key) const;
    Node operator[](std::string_view key) const; ///< a member that must exist
    Node operator[](std::size_t i) const;        ///< an element
    std::size_t size() const;                    ///< of an array

    double number() const;
    double number(std::string_view key, double otherwise) const; ///< of a member that may be missing
    double positive(std::string_view key, double otherwise) const;
    std::int64_t integer(std::int64_t least, std::int64_t most) const;
    std::uint64_t natural() const; ///< 0 to 2^64 - 1
    std::string text() const;
    bool boolean() const;
    Eigen::Vector3d vector3() const;
    /// An array of exactly `count` numbers, written to `out`.
    void numbers(std::size_t count, double* out) const;

private:
    Node(const Json& value, std::string_view file, std::string path)
        : value_(&value), file_(file), path_(std::move(path))
    {
    }
    Node child(const Json& value, std::string_view key) const;
    void must_be(bool right, std::string_view what) const;

    const Json* value_;
    std::string_view file_;
    std::string path_; ///< "bodies[3].motion"; empty at the root
};

} // namespace oncollide
