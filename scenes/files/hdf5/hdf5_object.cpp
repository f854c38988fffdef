#include <oncollide/scenes/files/hdf5/hdf5_object.hpp>

#include <algorithm>

namespace oncollide {

Hdf5Object::Hdf5Object(Hdf5Walk& walk, std::uint64_t address) : address_(address)
{
    if (walk.block(address, 4).bytes == "OHDR")
        read_new(walk);
    else
        read_old(walk);
}

const Hdf5Message* Hdf5Object::find(Hdf5MessageType type) const
{
    const auto found = std::ranges::find(messages_, type, &Hdf5Message::type);
    return found == messages_.end() ? nullptr : &*found;
}

/// Reads version 1.
void Hdf5Object::read_old(Hdf5Walk& walk)
{
    constexpr unsigned prefix_bytes = 16, message_header = 8;
    const Hdf5Block prefix = walk.block(address_, prefix_bytes);
    Hdf5Cursor cursor = prefix.cursor(walk.file);
    if (cursor.u8() != 1) cursor.damaged("an object's header is missing");
    cursor.skip(7);
    pieces_.push_back({address_ + prefix_bytes, cursor.u32()});
    while (!pieces_.empty()) {
        const Piece piece = pieces_.back();
        pieces_.pop_back();
        const Hdf5Block block = walk.block(piece.address, piece.size);
        add_messages(block.cursor(walk.file), message_header);
    }
}

/// Reads version 2.
void Hdf5Object::read_new(Hdf5Walk& walk)
{
    constexpr unsigned start_bytes = 6, checksum_bytes = 4;
    enum Flag { size_bytes = 3, has_order = 4, has_limits = 16, has_times = 32 };
    const Hdf5Block start = walk.block(address_, start_bytes);
    Hdf5Cursor cursor = start.cursor(walk.file);
    cursor.expect("OHDR", 2);
    const unsigned flags = cursor.u8(), length = 1U << (flags & size_bytes), header = flags & has_order ? 6 : 4,
                   prefix = start_bytes + (flags & has_times ? 16 : 0) + (flags & has_limits ? 4 : 0) + length;
    const std::uint64_t size = walk.block(address_ + prefix - length, length).cursor(walk.file).number(length);
    const auto add = [&](std::uint64_t address, std::uint64_t bytes, unsigned before) {
        const Hdf5Block block = walk.checked(address, bytes);
        Hdf5Cursor inside = block.cursor(walk.file);
        inside.skip(before);
        add_messages(inside.part(bytes - before - checksum_bytes), header);
    };
    if (size > walk.file.size()) cursor.damaged("an object's header is longer than the file");
    add(address_, prefix + size + checksum_bytes, prefix);
    while (!pieces_.empty()) {
        const Piece piece = pieces_.back();
        pieces_.pop_back();
        if (piece.size < 8 || walk.block(piece.address, 4).bytes != "OCHK")
            hdf5_damaged(piece.address, "the continuation of an object's header is missing");
        add(piece.address, piece.size, 4);
    }
}

void Hdf5Object::add_messages(Hdf5Cursor cursor, unsigned header_bytes)
{
    enum Flag { shared = 2, unknown_is_error = 128 };
    const bool old = header_bytes == 8;
    while (cursor.left() >= header_bytes) { // a gap may follow the last message
        const auto type = static_cast<Hdf5MessageType>(old ? cursor.u16() : cursor.u8());
        const std::uint16_t size = cursor.u16();
        const unsigned flags = cursor.u8();
        cursor.skip(header_bytes - (old ? 5 : 4));
        Hdf5Cursor content = cursor.part(size);
        if (type == Hdf5MessageType::nothing) continue;
        if (type > Hdf5MessageType::last_known && flags & unknown_is_error)
            hdf5_unread("a feature of a newer version of HDF5");
        if (type != Hdf5MessageType::continuation) {
            const std::uint64_t place = content.here();
            messages_.push_back({type, (flags & shared) != 0, {std::string(content.take(size)), place}});
            continue;
        }
        const std::uint64_t address = content.address();
        pieces_.push_back({address, content.length()});
    }
}

Hdf5Block hdf5_content(Hdf5Walk& walk, const Hdf5Message& message)
{
    if (!message.is_shared) return message.block;
    return hdf5_content(walk, message.block.cursor(walk.file), message.type);
}

Hdf5Block hdf5_content(Hdf5Walk& walk, Hdf5Cursor shared, Hdf5MessageType type)
{
    const unsigned version = shared.u8(), kind = shared.u8();
    if (version == 1) shared.skip(6);
    if (version == 0 || version > 3 || (version == 3 && kind != 2)) hdf5_unread("a table of shared messages");
    const Hdf5Object named(walk, shared.address());
    const Hdf5Message* const found = named.find(type);
    if (!found || found->is_shared) shared.damaged("a named type is missing");
    return found->block;
}

} // namespace oncollide
