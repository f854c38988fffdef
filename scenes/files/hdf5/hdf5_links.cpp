#include <oncollide/scenes/files/hdf5/hdf5_links.hpp>

#include <algorithm>

#include <oncollide/scenes/files/hdf5/hdf5_btree.hpp>
#include <oncollide/scenes/files/hdf5/hdf5_heap.hpp>

namespace oncollide {

namespace {

/// A link message.
Hdf5Link link_of(Hdf5Cursor cursor)
{
    enum Flag { name_bytes = 3, has_order = 4, has_kind = 8, has_encoding = 16 };
    constexpr unsigned hard = 0, soft = 1, external = 64;
    if (cursor.u8() != 1) hdf5_unread("a newer version of links");
    const unsigned flags = cursor.u8(), kind = flags & has_kind ? cursor.u8() : hard;
    cursor.skip((flags & has_order ? 8 : 0) + (flags & has_encoding ? 1 : 0));
    const std::uint64_t length = cursor.number(1U << (flags & name_bytes));
    Hdf5Link link{std::string(cursor.take(length)), Hdf5Link::Kind::other, 0, {}};
    if (kind == hard) link.kind = Hdf5Link::Kind::hard, link.address = cursor.address();
    if (kind == soft) {
        const std::uint16_t bytes = cursor.u16();
        link.kind = Hdf5Link::Kind::soft, link.target = cursor.take(bytes);
    }
    if (kind == external) link.kind = Hdf5Link::Kind::external;
    return link;
}

/// Adds the links of one leaf of a group's tree.
void add_symbols(Hdf5Walk& walk, std::uint64_t address, const Hdf5LocalHeap& names, std::vector<Hdf5Link>& links)
{
    constexpr unsigned prefix_bytes = 8, soft = 2;
    const Hdf5Block prefix = walk.block(address, prefix_bytes);
    Hdf5Cursor start = prefix.cursor(walk.file);
    start.expect("SNOD", 1);
    start.skip(1);
    const std::uint64_t symbols = start.u16(), symbol_bytes = 24 + 2 * walk.file.offset_bytes();
    const Hdf5Block block = walk.block(address + prefix_bytes, symbols * symbol_bytes);
    Hdf5Cursor cursor = block.cursor(walk.file);
    for (std::uint64_t i = 0; i < symbols; ++i) {
        Hdf5Cursor symbol = cursor.part(symbol_bytes);
        Hdf5Link link{std::string(names.text(symbol.number(walk.file.offset_bytes()))), {}, symbol.address(), {}};
        if (symbol.u32() == soft) {
            symbol.skip(4);
            link.kind = Hdf5Link::Kind::soft, link.target = names.text(symbol.u32());
        }
        links.push_back(std::move(link));
    }
}

void add_table(Hdf5Walk& walk, Hdf5Cursor table, std::vector<Hdf5Link>& links)
{
    const std::uint64_t tree = table.address();
    const Hdf5LocalHeap names(walk, table.address());
    walk_old_btree(walk, tree, 0, walk.file.length_bytes(),
                   [&](Hdf5Cursor, std::uint64_t leaf) { add_symbols(walk, leaf, names, links); });
}

/// Links that do not fit into the group's header.
void add_many(Hdf5Walk& walk, Hdf5Cursor info, std::vector<Hdf5Link>& links)
{
    constexpr unsigned has_order = 1, hash_bytes = 4, by_name = 5;
    if (info.u8() != 0) hdf5_unread("a newer version of groups");
    if (info.u8() & has_order) info.skip(8);
    const std::uint64_t heap_address = info.address(), tree = info.address();
    if (heap_address == hdf5_nowhere) return;
    Hdf5FractalHeap heap(walk, heap_address);
    walk_btree(walk, tree, by_name, by_name, [&](Hdf5Cursor record) {
        record.skip(hash_bytes);
        links.push_back(link_of(heap.object(record).cursor(walk.file)));
    });
}

/// Adds the names of a path in reverse order.
void add_steps(std::string_view path, std::vector<std::string>& steps)
{
    const auto before = static_cast<std::ptrdiff_t>(steps.size());
    while (!path.empty()) {
        const std::string_view name = path.substr(0, path.find('/'));
        path.remove_prefix(std::min(path.size(), name.size() + 1));
        if (!name.empty() && name != ".") steps.emplace_back(name);
    }
    std::reverse(steps.begin() + before, steps.end());
}

} // namespace

std::optional<std::vector<Hdf5Link>> hdf5_links(Hdf5Walk& walk, const Hdf5Object& object)
{
    std::vector<Hdf5Link> links;
    bool is_group = false;
    for (const Hdf5Message& message : object.messages()) {
        const Hdf5Cursor content = message.block.cursor(walk.file);
        if (message.type == Hdf5MessageType::symbol_table)
            is_group = true, add_table(walk, content, links);
        else if (message.type == Hdf5MessageType::link_info)
            is_group = true, add_many(walk, content, links);
        else if (message.type == Hdf5MessageType::link)
            is_group = true, links.push_back(link_of(content));
    }
    if (!is_group) return std::nullopt;
    return links;
}

std::optional<Hdf5Object> find_hdf5_object(const Hdf5Bytes& file, std::string_view path)
{
    constexpr int most_steps = 200, most_links = 16; // links can form circles
    std::vector<std::string> steps;
    add_steps(path, steps);
    std::uint64_t address = file.root();
    for (int step = 0, soft_links = 0; step < most_steps; ++step) {
        Hdf5Walk walk(file);
        const Hdf5Object object(walk, address);
        if (steps.empty()) return object;
        const auto links = hdf5_links(walk, object);
        if (!links) return std::nullopt;
        const auto link = std::ranges::find(*links, steps.back(), &Hdf5Link::name);
        if (link == links->end() || link->kind == Hdf5Link::Kind::other) return std::nullopt;
        if (link->kind == Hdf5Link::Kind::external) throw Hdf5Fault{hdf5_in_other_file};
        steps.pop_back();
        if (link->kind == Hdf5Link::Kind::hard) {
            address = link->address;
            continue;
        }
        if (++soft_links > most_links) return std::nullopt;
        if (link->target.starts_with('/')) address = file.root();
        add_steps(link->target, steps);
    }
    return std::nullopt;
}

} // namespace oncollide
