#pragma once
#include <string>
#include <utility>
#include <vector>

#include <oncollide/scenes/files/hdf5/hdf5_bytes.hpp>

namespace oncollide {

// Types of values in HDF5 files. Private to scenes.

struct Hdf5Type {
    enum class Kind {
        whole,       ///< 1, 2, 4 or 8 bytes
        real,        ///< IEEE, 2, 4 or 8 bytes
        text,        ///< a text of variable length
        enumeration, ///< an enumeration of bytes without sign
        compound,    ///< a compound of all kinds except texts and compounds
        other
    };
    Kind kind = Kind::other;
    std::uint64_t size = 0; ///< bytes of a value
    bool is_signed = false, is_big_endian = false;
    std::vector<std::pair<std::string, std::uint8_t>> names; ///< names of an enumeration
    struct Member;
    std::vector<Member> members; ///< members of a compound
};

struct Hdf5Type::Member {
    std::string name;
    std::uint64_t offset;
    Hdf5Type type;
};

constexpr const char* hdf5_other_type = "holds values of another type";

/// @param cursor  at the beginning of a datatype message
Hdf5Type hdf5_type(Hdf5Cursor cursor);

} // namespace oncollide
