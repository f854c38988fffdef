#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <oncollide/scenes/files/hdf5/hdf5_object.hpp>

namespace oncollide {

// Groups of HDF5 files: names of objects. Private to scenes.

struct Hdf5Link {
    enum class Kind { hard, soft, external, other };
    std::string name;
    Kind kind = Kind::hard;
    std::uint64_t address = 0; ///< hard link: address of the object
    std::string target;        ///< soft: its path
};

constexpr const char* hdf5_in_other_file =
    "is a link to another file, or has its data there; everything must be in one file";

/// Empty if the object is not a group.
std::optional<std::vector<Hdf5Link>> hdf5_links(Hdf5Walk& walk, const Hdf5Object& object);

/// The object of a path from the root group, through soft links; empty if there is none. Throws Hdf5Fault for a link to
/// another file.
std::optional<Hdf5Object> find_hdf5_object(const Hdf5Bytes& file, std::string_view path);

} // namespace oncollide
