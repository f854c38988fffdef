#include <oncollide/scenes/files/octomap_nodes.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/mesh/mesh_source.hpp>
#include <oncollide/scenes/model/map/map_change.hpp>

namespace oncollide {

namespace {

constexpr int tree_depth = 16;
constexpr std::string_view coloured = "ColorOcTree"; ///< its `.ot` files have a colour in each node
constexpr std::int64_t most_nodes = 20'000'000;      ///< an octree of that size takes over a gigabyte in OctoMap

/// The text before the nodes.
struct Header {
    std::string id;
    std::int64_t nodes = -1;
    double resolution = 0;
    std::size_t bytes = 0;
};

Header read_header(const MeshSource& source, bool binary)
{
    const std::string_view first = binary ? "# Octomap OcTree binary file" : "# Octomap OcTree file";
    if (!source.bytes.starts_with(first))
        source.fail(fmt::format("not an OctoMap: the file must begin with '{}'", first));
    Header header;
    for (std::size_t line = 1;; ++line) {
        const std::size_t end = source.bytes.find('\n', header.bytes);
        if (end == source.bytes.npos) source.fail("the file ends within the header", line);
        std::string_view text = source.bytes.substr(header.bytes, end - header.bytes);
        while (!text.empty() && is_blank(text.back())) text.remove_suffix(1); // lines may end with CR LF
        header.bytes = end + 1;
        const std::size_t space = std::min(text.find(' '), text.size());
        const std::string_view keyword = text.substr(0, space), value = text.substr(std::min(space + 1, text.size()));
        if (keyword == "data") break;
        if (text.starts_with('#') || text.empty()) continue;
        if (keyword == "id")
            header.id = value;
        else if (keyword == "size" && parse(value, header.nodes))
            continue;
        else if (keyword == "res" && parse(value, header.resolution))
            continue;
        else
            source.fail(fmt::format("invalid header line {}; known are id, size, res, data", oncollide::quoted(text)),
                        line);
    }
    if (header.id != "OcTree" && header.id != coloured)
        source.fail(
            fmt::format("the tree's id is {}; OcTree and {} can be read", oncollide::quoted(header.id), coloured));
    check_resolution(source.name, header.resolution);
    if (header.nodes < 0) source.fail("the header gives no size");
    if (header.nodes == 0) source.fail("the map is empty");
    if (header.nodes > most_nodes)
        source.fail(fmt::format("the map has {} nodes; at most {} are allowed", header.nodes, most_nodes));
    return header;
}

/// Reads the nodes, which are stored depth first.
class Nodes {
public:
    Nodes(const MeshSource& source, std::size_t start, bool unknown_is_occupied)
        : source_(source), at_(start), cells_(unknown_is_occupied)
    {
    }

    OctomapNodes finish(const Header& header)
    {
        if (at_ != source_.bytes.size())
            source_.fail(fmt::format("damaged: {} bytes follow after the last node", source_.bytes.size() - at_));
        if (nodes_ != header.nodes)
            source_.fail(fmt::format("damaged: the header announces {} nodes, but there are {}", header.nodes, nodes_));
        return {header.resolution, header.bytes, std::move(cells_)};
    }

protected:
    template <class Number>
    Number read()
    {
        if (source_.bytes.size() - at_ < sizeof(Number))
            source_.fail("truncated: the file ends within the tree's nodes");
        Number number;
        std::memcpy(&number, source_.bytes.data() + at_, sizeof(Number));
        at_ += sizeof(Number);
        return number;
    }
    [[noreturn]] void too_deep() const
    {
        source_.fail(fmt::format("damaged: a node lies deeper than {} levels", tree_depth));
    }

    const MeshSource& source_;
    std::size_t at_;
    std::int64_t nodes_ = 1;
    CellTree cells_;
};

class BinaryNodes : public Nodes {
public:
    using Nodes::Nodes;
    void read_all()
    {
        cells_.reserve((source_.bytes.size() - at_) / 2);
        if (source_.bytes.size() - at_ == 2 && source_.bytes.substr(at_) == std::string_view("\0\0", 2)) {
            at_ += 2;
            return cells_.set_grid(CellState::occupied); // as in OctoMap
        }
        cells_.set_grid(node(0));
    }

private:
    /// Two bits per child: 00 none, 01 free, 10 occupied, 11 a node.
    CellTree::Node node(int depth)
    {
        const unsigned first = read<std::uint8_t>(), bits = first | unsigned{read<std::uint8_t>()} << 8;
        if (bits == 0) source_.fail("damaged: an inner node without children");
        if (depth >= tree_depth) too_deep();
        const unsigned low = evens(bits), high = evens(bits >> 1), inner = low & high;
        CellTree::Octants octants(static_cast<std::uint8_t>(high & ~inner), static_cast<std::uint8_t>(low & ~inner));
        nodes_ += CellTree::bits_in(low | high);
        for (unsigned left = inner; left; left &= left - 1)
            octants.set(static_cast<unsigned>(__builtin_ctz(left)), node(depth + 1));
        return cells_.close(octants);
    }
    /// Gathers bits 0, 2, 4, ... into adjacent bits.
    static unsigned evens(unsigned bits)
    {
        bits &= 0x5555;
        bits = (bits | bits >> 1) & 0x3333;
        bits = (bits | bits >> 2) & 0x0f0f;
        return (bits | bits >> 4) & 0xff;
    }
};

class FullNodes : public Nodes {
public:
    FullNodes(const MeshSource& source, std::size_t start, bool unknown_is_occupied, double threshold)
        : Nodes(source, start, unknown_is_occupied),
          least_(static_cast<float>(std::log(threshold / (1 - threshold)))) // rounded as in OctoMap
    {
    }
    void read_all()
    {
        const Record root = record();
        if (root.children)
            cells_.set_grid(node(root, 0));
        else
            cells_.set_grid(state(root));
    }

private:
    struct Record {
        float log_odds;
        unsigned children;
    };
    Record record()
    {
        const auto log_odds = read<float>();
        if (!std::isfinite(log_odds)) source_.fail("damaged: an occupancy is not finite");
        return {log_odds, read<std::uint8_t>()};
    }
    CellState state(const Record& leaf) const
    {
        return leaf.log_odds >= least_ ? CellState::occupied : CellState::free;
    }
    CellTree::Node node(const Record& from, int depth)
    {
        if (depth >= tree_depth) too_deep();
        CellTree::Octants octants;
        for (unsigned k = 0; k < 8; ++k) {
            if (!(from.children >> k & 1)) continue;
            ++nodes_;
            const Record child = record();
            if (child.children)
                octants.set(k, node(child, depth + 1));
            else
                octants.set(k, state(child));
        }
        return cells_.close(octants);
    }

    const float least_;
};

/// A node is a probability of four bytes, the colour's three, and a byte that says which children follow.
void drop_colours(std::string& bytes, std::size_t begin)
{
    constexpr std::size_t whole = 8, probability = 4;
    std::size_t to = begin;
    for (std::size_t from = begin; from < bytes.size(); from += whole) {
        const std::size_t size = std::min(whole, bytes.size() - from); // the last node may be cut off
        std::memmove(&bytes[to], &bytes[from], std::min(size, probability));
        to += std::min(size, probability);
        if (size == whole) bytes[to++] = bytes[from + whole - 1];
    }
    bytes.resize(to);
}

} // namespace

OctomapNodes read_binary_octomap(const std::string& name, std::string_view bytes, bool unknown_is_occupied)
{
    const MeshSource source{name, bytes};
    const Header header = read_header(source, true);
    BinaryNodes nodes(source, header.bytes, unknown_is_occupied);
    nodes.read_all();
    return nodes.finish(header);
}

OctomapNodes read_full_octomap(const std::string& name, std::string& bytes, bool unknown_is_occupied,
                               double occupancy_threshold)
{
    const Header header = read_header({name, bytes}, false);
    if (header.id == coloured) drop_colours(bytes, header.bytes);
    const MeshSource source{name, bytes};
    FullNodes nodes(source, header.bytes, unknown_is_occupied, occupancy_threshold);
    nodes.read_all();
    return nodes.finish(header);
}

} // namespace oncollide
