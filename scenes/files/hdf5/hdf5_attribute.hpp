#pragma once
#include <string>

#include <oncollide/scenes/files/hdf5/hdf5_object.hpp>
#include <oncollide/scenes/files/hdf5/hdf5_type.hpp>

namespace oncollide {

/// A small value of an object. Private to scenes.
struct Hdf5Attribute {
    Hdf5Type type;
    Hdf5Block data;
};

/// Throws Hdf5Fault if there is none of that name.
Hdf5Attribute hdf5_attribute(Hdf5Walk& walk, const Hdf5Object& object, const std::string& name);

} // namespace oncollide
