#include <oncollide/scenes/files/hdf5/hdf5_type.hpp>

#include <algorithm>
#include <bit>

namespace oncollide {

namespace {

enum Class { fixed_point = 0, floating_point = 1, compound = 6, enumeration = 8, variable_length = 9 };

struct TypeHeader {
    unsigned version, kind, bits; ///< bits: their meaning depends on the kind
};

Hdf5Type read_type(Hdf5Cursor& cursor, bool is_member);

bool is_number_size(std::uint64_t size)
{
    return size <= 8 && std::has_single_bit(size);
}

void read_whole(Hdf5Cursor& cursor, const TypeHeader& header, Hdf5Type& type)
{
    constexpr unsigned big_endian = 1, with_sign = 8;
    const unsigned offset = cursor.u16(), precision = cursor.u16();
    type.is_big_endian = header.bits & big_endian, type.is_signed = header.bits & with_sign;
    if (is_number_size(type.size) && offset == 0 && precision == 8 * type.size) type.kind = Hdf5Type::Kind::whole;
}

/// Accepts only the layouts of IEEE 754.
void read_real(Hdf5Cursor& cursor, const TypeHeader& header, Hdf5Type& type)
{
    constexpr unsigned big_endian = 1, vax = 0x40, normalisation = 0x30, implied_one = 0x20;
    const unsigned offset = cursor.u16(), precision = cursor.u16(), exponent_at = cursor.u8(), exponent = cursor.u8(),
                   mantissa_at = cursor.u8(), mantissa = cursor.u8(), bias = cursor.u32();
    type.is_big_endian = header.bits & big_endian;
    if (type.size < 2 || !is_number_size(type.size) || header.bits & vax ||
        (header.bits & normalisation) != implied_one)
        return;
    const unsigned bits = 8 * static_cast<unsigned>(type.size), wanted = bits == 16 ? 5 : bits == 32 ? 8 : 11;
    if (offset == 0 && precision == bits && exponent == wanted && mantissa == bits - 1 - wanted && mantissa_at == 0 &&
        exponent_at == mantissa && bias == (1U << (wanted - 1)) - 1 && header.bits >> 8 == bits - 1)
        type.kind = Hdf5Type::Kind::real;
}

/// Reads the name of a member; before version 3 it is padded to a multiple of eight bytes.
std::string read_name(Hdf5Cursor& cursor, const TypeHeader& header)
{
    std::string name(cursor.text());
    if (header.version < 3) cursor.skip((8 - (name.size() + 1) % 8) % 8);
    return name;
}

void read_enumeration(Hdf5Cursor& cursor, const TypeHeader& header, Hdf5Type& type)
{
    const Hdf5Type base = read_type(cursor, true);
    if (base.kind != Hdf5Type::Kind::whole || base.size != 1 || type.size != 1) return;
    const unsigned count = header.bits & 0xffff;
    for (unsigned i = 0; i < count; ++i) type.names.emplace_back(read_name(cursor, header), std::uint8_t{0});
    for (auto& [name, value] : type.names) value = cursor.u8();
    type.kind = Hdf5Type::Kind::enumeration;
}

void read_compound(Hdf5Cursor& cursor, const TypeHeader& header, Hdf5Type& type)
{
    const unsigned offset_bytes = header.version < 3 ? 4 : (static_cast<unsigned>(std::bit_width(type.size)) + 7) / 8;
    for (unsigned i = header.bits & 0xffff; i > 0; --i) {
        std::string name = read_name(cursor, header);
        const std::uint64_t offset = cursor.number(offset_bytes);
        if (header.version == 1) {
            if (cursor.u8() != 0) return; // it is an array
            cursor.skip(3 + 4 + 4 + 16);
        }
        const Hdf5Type member = read_type(cursor, true);
        if (member.kind == Hdf5Type::Kind::other) return;
        if (offset > type.size || member.size > type.size - offset) cursor.damaged("a member is outside its row");
        type.members.push_back({std::move(name), offset, member});
    }
    type.kind = Hdf5Type::Kind::compound;
}

/// @param is_member  the type is a member of another type, so it must not be a compound or a text
Hdf5Type read_type(Hdf5Cursor& cursor, bool is_member)
{
    const unsigned first = cursor.u8();
    const TypeHeader header{first >> 4, first & 15, static_cast<unsigned>(cursor.number(3))};
    Hdf5Type type;
    type.size = cursor.u32();
    if (type.size == 0) cursor.damaged("values have no bytes");
    if (header.version == 0 || header.version > 5) hdf5_unread("a newer version of types");
    constexpr unsigned variable_kind = 15, text = 1;
    if (header.kind == fixed_point)
        read_whole(cursor, header, type);
    else if (header.kind == floating_point)
        read_real(cursor, header, type);
    else if (header.kind == enumeration)
        read_enumeration(cursor, header, type);
    else if (header.kind == compound && !is_member && type.size <= 65'536)
        read_compound(cursor, header, type);
    else if (header.kind == variable_length && !is_member && (header.bits & variable_kind) == text && type.size <= 24)
        type.kind = Hdf5Type::Kind::text;
    return type;
}

} // namespace

Hdf5Type hdf5_type(Hdf5Cursor cursor)
{
    return read_type(cursor, false);
}

} // namespace oncollide
