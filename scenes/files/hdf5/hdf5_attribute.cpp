#include <oncollide/scenes/files/hdf5/hdf5_attribute.hpp>

#include <optional>

#include <fmt/format.h>

#include <oncollide/scenes/files/hdf5/hdf5_btree.hpp>
#include <oncollide/scenes/files/hdf5/hdf5_heap.hpp>

namespace oncollide {

namespace {

/// An attribute message; empty if it has another name.
std::optional<Hdf5Attribute> attribute_of(Hdf5Walk& walk, Hdf5Cursor cursor, const std::string& wanted)
{
    constexpr unsigned type_is_shared = 1;
    const unsigned version = cursor.u8(), flags = cursor.u8();
    if (version < 1 || version > 3) hdf5_unread("a newer version of attributes");
    const std::uint64_t name_bytes = cursor.u16(), type_bytes = cursor.u16(), space_bytes = cursor.u16();
    if (version == 3) cursor.skip(1); // encoding of the name
    const auto padded = [&](std::uint64_t bytes) { return version == 1 ? (bytes + 7) / 8 * 8 : bytes; };
    Hdf5Cursor name = cursor.part(padded(name_bytes));
    if (name.text() != wanted) return std::nullopt;
    const Hdf5Cursor type = cursor.part(padded(type_bytes));
    cursor.skip(padded(space_bytes));
    Hdf5Attribute attribute;
    if (version > 1 && flags & type_is_shared)
        attribute.type = hdf5_type(hdf5_content(walk, type, Hdf5MessageType::datatype).cursor(walk.file));
    else
        attribute.type = hdf5_type(type);
    const std::uint64_t address = cursor.here();
    attribute.data = {std::string(cursor.take(cursor.left())), address};
    return attribute;
}

/// Attributes that do not fit into the object's header.
std::optional<Hdf5Attribute> read_many(Hdf5Walk& walk, Hdf5Cursor info, const std::string& name)
{
    constexpr unsigned has_order = 1, by_name = 8, id_bytes = 8;
    if (info.u8() != 0) hdf5_unread("a newer version of attributes");
    if (info.u8() & has_order) info.skip(2);
    const std::uint64_t heap_address = info.address(), tree = info.address();
    if (heap_address == hdf5_nowhere) return std::nullopt;
    Hdf5FractalHeap heap(walk, heap_address);
    std::optional<Hdf5Attribute> found;
    walk_btree(walk, tree, by_name, by_name, [&](Hdf5Cursor record) {
        const Hdf5Block message = heap.object(record.part(id_bytes));
        if (!found) found = attribute_of(walk, message.cursor(walk.file), name);
    });
    return found;
}

} // namespace

Hdf5Attribute hdf5_attribute(Hdf5Walk& walk, const Hdf5Object& object, const std::string& name)
{
    std::optional<Hdf5Attribute> found;
    for (const Hdf5Message& message : object.messages()) {
        if (message.type == Hdf5MessageType::attribute && !message.is_shared)
            found = attribute_of(walk, message.block.cursor(walk.file), name);
        else if (message.type == Hdf5MessageType::attribute_info)
            found = read_many(walk, message.block.cursor(walk.file), name);
        if (found) return *found;
    }
    throw Hdf5Fault{fmt::format("has no attribute '{}'", name)};
}

} // namespace oncollide
