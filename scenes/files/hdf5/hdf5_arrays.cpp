// The arrays by which the newer layouts find chunks.
#include <algorithm>
#include <bit>

#include <oncollide/scenes/files/hdf5/hdf5_chunks.hpp>

namespace oncollide {

namespace {

constexpr unsigned array_checksum_bytes = 4;

/// A run of consecutive elements.
struct Run {
    Hdf5Walk& walk;
    VisitHdf5Element visit;
    std::uint64_t element_bytes = 0, page_elements = 0; ///< sizes of a page

    void elements(Hdf5Cursor& cursor, std::uint64_t first, std::uint64_t count) const
    {
        for (std::uint64_t i = 0; i < count; ++i) visit(first + i, cursor.part(element_bytes));
    }
    /// Pages at an address, each with a checksum. A page without a bit in `pages` was not written.
    /// @param bit  the bit of the first page; the highest bit of a byte is the first
    void paged(std::uint64_t address, std::uint64_t first, std::uint64_t count, std::string_view pages,
               std::uint64_t bit) const
    {
        for (std::uint64_t done = 0; done < count; done += page_elements, ++bit) {
            const std::uint64_t here = std::min(page_elements, count - done),
                                bytes = here * element_bytes + array_checksum_bytes;
            if (bit / 8 >= pages.size()) hdf5_damaged(address, "an array has more pages than it should");
            if (static_cast<unsigned char>(pages[bit / 8]) & (0x80 >> bit % 8)) {
                const Hdf5Block block = walk.checked(address, bytes);
                Hdf5Cursor cursor = block.cursor(walk.file);
                elements(cursor, first + done, here);
            }
            address += bytes;
        }
    }
};

/// Throws if a dataset without filters has an array of chunks with filters, or the reverse.
void expect_kind(Hdf5Cursor& cursor, unsigned kind)
{
    if (cursor.u8() != kind) cursor.damaged("an array is not of this dataset");
}

/// The numbers of a header determine the sizes of all blocks.
struct ExtensibleArray {
    Run run;
    unsigned kind;
    std::uint64_t bits = 0, in_index = 0, least = 0, least_blocks = 0;

    unsigned prefix() const { return 6 + run.walk.file.offset_bytes(); }
    unsigned offset_in_array() const { return static_cast<unsigned>((bits + 7) / 8); }
    std::uint64_t blocks(unsigned group) const { return std::uint64_t{1} << group / 2; }
    std::uint64_t elements(unsigned group) const { return least << (group + 1) / 2; }
    bool is_paged(unsigned group) const { return elements(group) > run.page_elements; }

    /// @param pages  which pages of the block's group were written; the block is the number `block` of the group
    void data_block(std::uint64_t address, std::uint64_t first, unsigned group, std::string_view pages,
                    std::uint64_t block) const
    {
        if (address == hdf5_nowhere) return;
        const std::uint64_t count = elements(group), start = prefix() + offset_in_array();
        if (count > run.walk.file.size() / run.element_bytes) hdf5_damaged(address, "an array is larger than the file");
        const std::uint64_t bytes = start + (is_paged(group) ? 0 : count * run.element_bytes) + array_checksum_bytes;
        const Hdf5Block read = run.walk.checked(address, bytes);
        Hdf5Cursor cursor = read.cursor(run.walk.file);
        cursor.expect("EADB", 0);
        expect_kind(cursor, kind);
        cursor.skip(start - 6);
        if (is_paged(group))
            run.paged(address + bytes, first, count, pages, block * (count / run.page_elements));
        else
            run.elements(cursor, first, count);
    }

    void group_block(std::uint64_t address, std::uint64_t first, unsigned group) const
    {
        if (address == hdf5_nowhere) return;
        const std::uint64_t count = blocks(group);
        if (count > run.walk.file.size()) hdf5_damaged(address, "an array is larger than the file");
        const std::uint64_t page_bytes = is_paged(group) ? (elements(group) / run.page_elements + 7) / 8 * count : 0;
        const Hdf5Block read =
            run.walk.checked(address, prefix() + offset_in_array() + page_bytes + count * run.walk.file.offset_bytes() +
                                          array_checksum_bytes);
        Hdf5Cursor cursor = read.cursor(run.walk.file);
        cursor.expect("EASB", 0);
        expect_kind(cursor, kind);
        cursor.skip(prefix() - 6 + offset_in_array());
        const std::string_view pages = cursor.take(page_bytes);
        for (std::uint64_t i = 0; i < count; ++i)
            data_block(cursor.address(), first + i * elements(group), group, pages, i);
    }

    void index_block(std::uint64_t address) const
    {
        const unsigned groups = 1 + static_cast<unsigned>(bits) - static_cast<unsigned>(std::bit_width(least) - 1),
                       inside = std::min(groups, 2 * static_cast<unsigned>(std::bit_width(least_blocks) - 1));
        std::uint64_t addresses = groups - inside;
        for (unsigned group = 0; group < inside; ++group) addresses += blocks(group);
        const Hdf5Block read =
            run.walk.checked(address, prefix() + in_index * run.element_bytes +
                                          addresses * run.walk.file.offset_bytes() + array_checksum_bytes);
        Hdf5Cursor cursor = read.cursor(run.walk.file);
        cursor.expect("EAIB", 0);
        expect_kind(cursor, kind);
        cursor.skip(prefix() - 6);
        run.elements(cursor, 0, in_index);
        std::uint64_t first = in_index;
        for (unsigned group = 0; group < groups; ++group) {
            if (group >= inside) group_block(cursor.address(), first, group);
            for (std::uint64_t i = 0; group < inside && i < blocks(group); ++i)
                data_block(cursor.address(), first + i * elements(group), group, {}, 0);
            first += blocks(group) * elements(group);
        }
    }
};

} // namespace

void walk_fixed_array(Hdf5Walk& walk, std::uint64_t header, unsigned element_kind, VisitHdf5Element visit)
{
    const Hdf5Block block =
        walk.checked(header, 8 + walk.file.length_bytes() + walk.file.offset_bytes() + array_checksum_bytes);
    Hdf5Cursor cursor = block.cursor(walk.file);
    cursor.expect("FAHD", 0);
    expect_kind(cursor, element_kind);
    const std::uint64_t element_bytes = cursor.u8();
    const unsigned page_bits = cursor.u8();
    const std::uint64_t count = cursor.length(), data = cursor.address();
    if (data == hdf5_nowhere) return;
    if (page_bits > 32 || element_bytes < walk.file.offset_bytes() || count > walk.file.size() / element_bytes)
        cursor.damaged("an array has impossible sizes");
    const Run run{walk, visit, element_bytes, std::uint64_t{1} << page_bits};
    const bool is_paged = count > run.page_elements;
    const std::uint64_t pages = (count + run.page_elements - 1) / run.page_elements,
                        prefix = 6 + walk.file.offset_bytes(),
                        bytes = prefix + (is_paged ? (pages + 7) / 8 : count * element_bytes) + array_checksum_bytes;
    const Hdf5Block read = walk.checked(data, bytes);
    Hdf5Cursor inside = read.cursor(walk.file);
    inside.expect("FADB", 0);
    expect_kind(inside, element_kind);
    inside.skip(prefix - 6);
    if (is_paged)
        run.paged(data + bytes, 0, count, inside.take((pages + 7) / 8), 0);
    else
        run.elements(inside, 0, count);
}

void walk_extensible_array(Hdf5Walk& walk, std::uint64_t header, unsigned element_kind, VisitHdf5Element visit)
{
    const Hdf5Block block =
        walk.checked(header, 12 + 6 * walk.file.length_bytes() + walk.file.offset_bytes() + array_checksum_bytes);
    Hdf5Cursor cursor = block.cursor(walk.file);
    cursor.expect("EAHD", 0);
    expect_kind(cursor, element_kind);
    ExtensibleArray array{{walk, visit}, element_kind};
    array.run.element_bytes = cursor.u8();
    array.bits = cursor.u8(), array.in_index = cursor.u8(), array.least = cursor.u8(), array.least_blocks = cursor.u8();
    const unsigned page_bits = cursor.u8();
    cursor.skip(6 * walk.file.length_bytes()); // statistics
    array.run.page_elements = std::uint64_t{1} << std::min(32u, page_bits);
    const auto least_bits = static_cast<std::uint64_t>(std::bit_width(array.least));
    if (array.run.element_bytes < walk.file.offset_bytes() || array.bits > 64 || array.bits < least_bits ||
        page_bits > 32 || !std::has_single_bit(array.least) || !std::has_single_bit(array.least_blocks))
        cursor.damaged("an array has impossible sizes");
    const std::uint64_t index = cursor.address();
    if (index != hdf5_nowhere) array.index_block(index);
}

} // namespace oncollide
