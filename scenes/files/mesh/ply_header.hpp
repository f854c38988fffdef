#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide::ply {

// The header of a PLY file. Private to scenes.

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
enum class Encoding { text, little_endian, big_endian };

/// A number in every row of an element, or a list of them.
struct Property {
    std::string name;
    Type type;
    std::optional<Type> list; ///< for a list: the type of its length
};
/// `count` rows of the same properties.
struct Element {
    std::string name;
    std::int64_t count;
    std::vector<Property> properties;
};
struct Header {
    Encoding encoding = Encoding::text;
    std::vector<Element> elements;
    std::size_t bytes = 0; ///< offset of the data
    std::size_t lines = 0;
};

/// Throws Error{bad_data} with the line for a header that is cut short, names unknown types or formats, or announces
/// more than the file can contain.
Header read_header(const MeshSource& source);

} // namespace oncollide::ply
