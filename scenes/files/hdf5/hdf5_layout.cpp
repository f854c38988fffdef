#include <oncollide/scenes/files/hdf5/hdf5_layout.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/scenes/files/hdf5/hdf5_links.hpp>

namespace oncollide {

namespace {

using Type = Hdf5MessageType;

/// A message that every dataset has.
Hdf5Block needed(Hdf5Walk& walk, const Hdf5Object& object, Type type)
{
    const Hdf5Message* const message = object.find(type);
    if (!message) hdf5_damaged(object.address(), "a part of a dataset's header is missing");
    return hdf5_content(walk, *message);
}

void read_edges(Hdf5Cursor& cursor, unsigned dimensions, unsigned bytes, Hdf5Layout& layout)
{
    if (dimensions < 2 || dimensions > hdf5_most_dimensions + 1 || bytes == 0 || bytes > 8)
        cursor.damaged("chunks have an impossible number of dimensions");
    for (unsigned i = 0; i + 1 < dimensions; ++i) layout.edges.push_back(cursor.number(bytes));
    layout.value_bytes = cursor.number(bytes);
    if (std::ranges::count(layout.edges, 0u)) cursor.damaged("chunks are empty");
}

void read_chunks_3(Hdf5Cursor& cursor, Hdf5Layout& layout)
{
    const unsigned dimensions = cursor.u8();
    layout.kind = Hdf5Layout::Kind::old_btree;
    layout.address = cursor.address();
    read_edges(cursor, dimensions, 4, layout);
}

void read_chunks_4(Hdf5Cursor& cursor, Hdf5Layout& layout)
{
    enum Flag { parts_unfiltered = 1, single_filtered = 2 };
    using Kind = Hdf5Layout::Kind;
    constexpr Kind kinds[] = {Kind::single, Kind::implicit, Kind::fixed_array, Kind::extensible_array, Kind::btree};
    constexpr unsigned parameter_bytes[] = {0, 0, 1, 5, 6};
    const unsigned flags = cursor.u8(), dimensions = cursor.u8(), bytes = cursor.u8();
    read_edges(cursor, dimensions, bytes, layout);
    const unsigned kind = cursor.u8();
    if (kind < 1 || kind > 5) hdf5_unread(fmt::format("index {} of chunks", kind));
    layout.kind = kinds[kind - 1];
    layout.parts_are_unfiltered = flags & parts_unfiltered;
    if (layout.kind == Kind::single && flags & single_filtered)
        layout.stored = cursor.length(), layout.skipped = cursor.u32();
    cursor.skip(parameter_bytes[kind - 1]); // the index has them, too
    layout.address = cursor.address();
}

std::string name_of(unsigned filter)
{
    switch (filter) {
    case 4:
        return "szip";
    case 5:
        return "n-bit";
    case 6:
        return "scale-offset";
    case 32000:
        return "LZF";
    case 32001:
        return "Blosc";
    case 32004:
        return "LZ4";
    case 32008:
        return "bitshuffle";
    case 32015:
        return "Zstandard";
    default:
        return fmt::format("number {}", filter);
    }
}

std::vector<Hdf5Filter> filters_of(Hdf5Cursor cursor)
{
    const unsigned version = cursor.u8(), count = cursor.u8();
    if (version != 1 && version != 2) hdf5_unread("a newer version of filters");
    if (version == 1) cursor.skip(6);
    std::vector<Hdf5Filter> filters;
    for (unsigned i = 0; i < count; ++i) {
        constexpr unsigned always_named = 256;
        const std::uint16_t kind = cursor.u16();
        const std::uint16_t name = version == 1 || kind >= always_named ? cursor.u16() : std::uint16_t{0};
        cursor.skip(2);
        const unsigned values = cursor.u16();
        cursor.skip(version == 1 ? (name + 7u) / 8 * 8 : name);
        Hdf5Cursor numbers = cursor.part(4 * values);
        if (version == 1 && values % 2) cursor.skip(4);
        if (kind < Hdf5Filter::deflate || kind > Hdf5Filter::fletcher)
            hdf5_unread(fmt::format("the compression or filter '{}'", name_of(kind)), "-f GZIP=4");
        if (std::ranges::find(filters, kind, &Hdf5Filter::kind) != filters.end())
            hdf5_unread("a filter that is used twice", "-f GZIP=4");
        filters.push_back({kind, values > 0 ? numbers.u32() : 0});
    }
    return filters;
}

} // namespace

Hdf5Space hdf5_space(Hdf5Walk& walk, const Hdf5Object& object)
{
    constexpr unsigned has_most = 1, null = 2;
    const Hdf5Block block = needed(walk, object, Type::dataspace);
    Hdf5Cursor cursor = block.cursor(walk.file);
    const unsigned version = cursor.u8(), dimensions = cursor.u8(), flags = cursor.u8();
    if (version != 1 && version != 2) hdf5_unread("a newer version of shapes");
    const unsigned kind = cursor.u8();
    if (version == 1) cursor.skip(4);
    if (dimensions > hdf5_most_dimensions || (version == 2 && kind == null)) hdf5_unread("a dataset without values");
    Hdf5Space space;
    for (unsigned i = 0; i < dimensions; ++i) space.extent.push_back(cursor.length());
    space.most = space.extent;
    if (flags & has_most)
        for (std::uint64_t& most : space.most) {
            most = cursor.length();
            if (most == hdf5_nowhere >> (64 - 8 * walk.file.length_bytes())) most = hdf5_nowhere;
        }
    for (unsigned i = 0; i < dimensions; ++i)
        if (space.most[i] < space.extent[i]) cursor.damaged("a dataset is larger than its limit");
    return space;
}

Hdf5Layout hdf5_layout(Hdf5Walk& walk, const Hdf5Object& object)
{
    enum Class { compact, contiguous, chunked, in_other_files };
    if (object.find(Type::external_files)) throw Hdf5Fault{hdf5_in_other_file};
    const Hdf5Block block = needed(walk, object, Type::layout);
    Hdf5Cursor cursor = block.cursor(walk.file);
    const unsigned version = cursor.u8();
    if (version < 3 || version > 4) hdf5_unread(fmt::format("version {} of layouts", version));
    Hdf5Layout layout;
    switch (cursor.u8()) {
    case compact:
        layout.data = cursor.take(cursor.u16());
        break;
    case contiguous:
        layout.kind = Hdf5Layout::Kind::contiguous, layout.address = cursor.address();
        break;
    case chunked:
        version == 3 ? read_chunks_3(cursor, layout) : read_chunks_4(cursor, layout);
        break;
    case in_other_files:
        throw Hdf5Fault{hdf5_in_other_file};
    default:
        cursor.damaged("unknown layout");
    }
    if (const Hdf5Message* const message = object.find(Type::filters); message && !layout.edges.empty())
        layout.filters = filters_of(hdf5_content(walk, *message).cursor(walk.file));
    return layout;
}

std::string hdf5_fill_value(Hdf5Walk& walk, const Hdf5Object& object, std::uint64_t bytes)
{
    const Hdf5Message* message = object.find(Type::fill_value);
    const bool old = !message;
    if (old) message = object.find(Type::old_fill_value);
    if (!message) return std::string(bytes, '\0');
    const Hdf5Block block = hdf5_content(walk, *message);
    Hdf5Cursor cursor = block.cursor(walk.file);
    bool is_defined = true;
    if (!old) {
        const unsigned version = cursor.u8();
        if (version < 1 || version > 3) hdf5_unread("a newer version of fill values");
        constexpr unsigned defined_3 = 0x20;
        if (version == 3)
            is_defined = cursor.u8() & defined_3;
        else
            cursor.skip(2), is_defined = cursor.u8() != 0;
    }
    const std::uint64_t size = is_defined && cursor.left() >= 4 ? cursor.u32() : 0;
    if (size == 0 || size == 0xffffffff) return std::string(bytes, '\0');
    if (size != bytes) cursor.damaged("a fill value has another size");
    return std::string(cursor.take(size));
}

} // namespace oncollide
