#include <oncollide/scenes/files/hdf5/hdf5_heap.hpp>

#include <algorithm>
#include <bit>

#include <oncollide/base/files/checksum.hpp>

namespace oncollide {

namespace {

using HeapObject = std::pair<unsigned, std::string_view>;

}

Hdf5LocalHeap::Hdf5LocalHeap(Hdf5Walk& walk, std::uint64_t address)
{
    const Hdf5Block header = walk.block(address, 8 + 2 * walk.file.length_bytes() + walk.file.offset_bytes());
    Hdf5Cursor cursor = header.cursor(walk.file);
    cursor.expect("HEAP", 0);
    cursor.skip(3);
    const std::uint64_t size = cursor.length();
    cursor.length(); // length of the first free piece, and its place
    data_ = walk.block(cursor.address(), size);
}

std::string_view Hdf5LocalHeap::text(std::uint64_t offset) const
{
    const std::string_view bytes = data_.bytes;
    const std::size_t end = offset < bytes.size() ? bytes.find('\0', offset) : bytes.npos;
    if (end == bytes.npos) hdf5_damaged(data_.address, "a name is not in its heap");
    return bytes.substr(offset, end - offset);
}

Hdf5FractalHeap::Hdf5FractalHeap(Hdf5Walk& walk, std::uint64_t address) : walk_(walk)
{
    const unsigned offset = walk.file.offset_bytes(), length = walk.file.length_bytes();
    const Hdf5Block header = walk.checked(address, 26 + 3 * offset + 12 * length);
    Hdf5Cursor cursor = header.cursor(walk.file);
    cursor.expect("FRHP", 0);
    cursor.skip(2); // length of ids
    if (cursor.u16() != 0) hdf5_unread("a group or attributes with filters");
    constexpr unsigned checked_blocks = 2;
    is_checked_ = (cursor.u8() & checked_blocks) != 0;
    const std::uint64_t largest = cursor.u32();
    cursor.skip(10 * length + 2 * offset); // large objects, free space, statistics
    width_ = cursor.u16();
    start_bytes_ = cursor.length(), most_direct_bytes_ = cursor.length();
    offset_bits_ = cursor.u16();
    cursor.skip(2);
    const std::uint64_t root = cursor.address();
    const unsigned rows = cursor.u16();
    root_ = {root, 0, rows == 0 ? start_bytes_ : 0, rows};
    if (width_ == 0 || !std::has_single_bit(start_bytes_) || !std::has_single_bit(most_direct_bytes_) ||
        most_direct_bytes_ < start_bytes_ || most_direct_bytes_ > std::uint64_t{1} << 32 || offset_bits_ > 64 ||
        rows > 64)
        cursor.damaged("a heap has impossible sizes");
    const auto bytes_of = [](int bits) { return (static_cast<unsigned>(bits) + 7) / 8; };
    size_bytes_ = std::min(bytes_of(std::bit_width(most_direct_bytes_) - 1), bytes_of(std::bit_width(largest)));
}

std::uint64_t Hdf5FractalHeap::row_bytes(unsigned row) const
{
    const unsigned shift = row > 0 ? row - 1 : 0;
    if (shift >= static_cast<unsigned>(std::countl_zero(start_bytes_ * width_))) return 0;
    return start_bytes_ << shift;
}

const Hdf5Block& Hdf5FractalHeap::read(const Place& place)
{
    const unsigned offset = walk_.file.offset_bytes(), prefix = 5 + offset + (offset_bits_ + 7) / 8;
    const auto [at, is_new] = blocks_.try_emplace(place.address);
    Hdf5Block& block = at->second;
    if (!is_new) return block;
    if (place.size == 0) {
        block = walk_.checked(place.address, prefix + place.rows * width_ * offset + 4);
        block.cursor(walk_.file).expect("FHIB", 0);
        return block;
    }
    block = walk_.block(place.address, place.size);
    Hdf5Cursor cursor = block.cursor(walk_.file);
    cursor.expect("FHDB", 0);
    if (!is_checked_) return block;
    cursor.skip(prefix - 5);
    const std::uint32_t stored = cursor.u32();
    std::string bytes = block.bytes;
    std::fill_n(bytes.begin() + prefix, 4, '\0');
    if (stored != lookup3(bytes)) hdf5_damaged(place.address, "wrong checksum");
    return block;
}

/// Returns the part of a table that has the offset.
Hdf5FractalHeap::Place Hdf5FractalHeap::child(const Place& table, std::uint64_t offset)
{
    const unsigned address_bytes = walk_.file.offset_bytes();
    std::uint64_t first = table.first;
    for (unsigned row = 0; row < table.rows; ++row) {
        const std::uint64_t size = row_bytes(row);
        if (size == 0) break;
        if (offset - first >= size * width_) {
            first += size * width_;
            continue;
        }
        const std::uint64_t column = (offset - first) / size;
        Hdf5Cursor cursor = read(table).cursor(walk_.file);
        cursor.skip(5 + address_bytes + (offset_bits_ + 7) / 8 + (row * width_ + column) * address_bytes);
        const bool direct = size <= most_direct_bytes_;
        const unsigned rows = static_cast<unsigned>(std::bit_width(size / start_bytes_ / width_));
        return {cursor.address(), first + column * size, direct ? size : 0, direct ? 0 : rows};
    }
    hdf5_damaged(table.address, "an object is not in its heap");
}

Hdf5Block Hdf5FractalHeap::object(Hdf5Cursor id)
{
    constexpr unsigned kind = 0xf0;
    if ((id.u8() & kind) != 0) hdf5_unread("a link or attribute of more than 4,000 bytes");
    const std::uint64_t offset = id.number((offset_bits_ + 7) / 8);
    const std::uint64_t size = id.number(size_bytes_);
    Place place = root_;
    for (int level = 0; place.size == 0; ++level) {
        if (level > 64 || place.rows == 0) id.damaged("a heap is too deep");
        place = child(place, offset);
    }
    const std::string& bytes = read(place).bytes;
    if (offset < place.first || offset - place.first > bytes.size() || size > bytes.size() - (offset - place.first))
        id.damaged("an object is not in its heap");
    return {bytes.substr(offset - place.first, size), place.address + (offset - place.first)};
}

const Hdf5TextHeap::Collection& Hdf5TextHeap::collection(std::uint64_t address)
{
    const auto [at, is_new] = collections_.try_emplace(address);
    Collection& found = at->second;
    if (!is_new) return found;
    const unsigned length = walk_.file.length_bytes(), prefix = 8 + length;
    const Hdf5Block start = walk_.block(address, prefix);
    Hdf5Cursor header = start.cursor(walk_.file);
    header.expect("GCOL", 1);
    header.skip(3);
    found.block = walk_.block(address, header.length());
    Hdf5Cursor cursor = found.block.cursor(walk_.file);
    cursor.skip(prefix);
    while (cursor.left() >= prefix) {
        const unsigned number = cursor.u16();
        cursor.skip(6);
        const std::uint64_t size = cursor.length();
        if (number == 0) break; // free space
        found.objects.emplace_back(number, cursor.take(size));
        cursor.skip(std::min(cursor.left(), (8 - size % 8) % 8));
    }
    std::ranges::sort(found.objects, {}, &HeapObject::first);
    return found;
}

std::string_view Hdf5TextHeap::text(Hdf5Cursor place)
{
    const std::uint64_t length = place.u32(), address = place.address();
    const unsigned number = place.u32();
    if (length == 0) return {};
    const std::vector<HeapObject>& objects = collection(address).objects;
    const auto found = std::ranges::lower_bound(objects, number, {}, &HeapObject::first);
    if (found == objects.end() || found->first != number || length > found->second.size())
        place.damaged("a text is not in its heap");
    const std::string_view text = found->second.substr(0, length);
    return text.substr(0, text.find('\0'));
}

} // namespace oncollide
