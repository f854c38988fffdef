#pragma once
#include <oncollide/base/function_ref.hpp>
#include <oncollide/scenes/files/hdf5/hdf5_bytes.hpp>

namespace oncollide {

// B-trees of HDF5 files. Private to scenes.

/// Calls visit(key before the child, address of the child) for each child of the leaves of a version-1 tree, in order.
/// @param type  0: groups, 1: chunks
void walk_old_btree(Hdf5Walk& walk, std::uint64_t root, unsigned type, unsigned key_bytes,
                    FunctionRef<void(Hdf5Cursor key, std::uint64_t child)> visit);

/// Calls visit(record) for each record of a version-2 tree.
/// @param types  the two types that are accepted
void walk_btree(Hdf5Walk& walk, std::uint64_t header, unsigned type, unsigned other_type,
                FunctionRef<void(Hdf5Cursor record)> visit);

} // namespace oncollide
