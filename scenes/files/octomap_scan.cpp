#include <oncollide/scenes/files/octomap_scan.hpp>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/mesh_source.hpp>
#include <oncollide/scenes/model/occupancy_cells.hpp>

namespace oncollide {

namespace {

constexpr int tree_depth = 16;
constexpr std::int64_t most_nodes = 20'000'000; ///< two bytes of a file may be eight nodes, which take over a kilobyte

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
        const std::string_view text = source.bytes.substr(header.bytes, end - header.bytes);
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
    if (header.id != "OcTree")
        source.fail(fmt::format("the tree's id is {}; only OcTree can be read", oncollide::quoted(header.id)));
    if (!(header.resolution >= least_resolution && header.resolution <= most_resolution))
        source.fail(fmt::format("the resolution is {}; it must be from {} to {} m", header.resolution, least_resolution,
                                most_resolution));
    if (header.nodes < 0) source.fail("the header gives no size");
    return header;
}

/// The nodes, depth first: `levels_` holds the depth of each node whose record is still to come.
class NodeWalk {
public:
    NodeWalk(const MeshSource& source, std::size_t start, bool binary) : source_(source), at_(start), binary_(binary) {}

    std::int64_t count()
    {
        std::vector<int> pending = {0};
        std::int64_t nodes = 1;
        while (!pending.empty()) {
            const int depth = pending.back();
            pending.pop_back();
            const Children children = binary_ ? read_binary() : read_full();
            if (children.inner + children.leaves > 0 && depth >= tree_depth)
                source_.fail(fmt::format("damaged: a node lies deeper than {} levels", tree_depth));
            if (binary_ && depth > 0 && children.inner + children.leaves == 0)
                source_.fail("damaged: an inner node without children");
            if (binary_ && children.inner > 0 && depth + 1 >= tree_depth)
                source_.fail(fmt::format("damaged: a node lies deeper than {} levels", tree_depth));
            nodes += children.inner + children.leaves;
            pending.insert(pending.end(), static_cast<std::size_t>(children.inner), depth + 1);
        }
        if (at_ != source_.bytes.size())
            source_.fail(fmt::format("damaged: {} bytes follow after the last node", source_.bytes.size() - at_));
        return nodes;
    }

private:
    struct Children {
        int inner, leaves;
    }; ///< with and without a record of their own

    void need(std::size_t bytes)
    {
        if (source_.bytes.size() - at_ < bytes) source_.fail("truncated: the file ends within the tree's nodes");
    }
    /// Two bits a child: 00 none, 01 and 10 a leaf, 11 a node.
    Children read_binary()
    {
        need(2);
        std::uint16_t bits;
        std::memcpy(&bits, source_.bytes.data() + at_, 2);
        at_ += 2;
        const unsigned low = bits & 0x5555u, high = (bits >> 1) & 0x5555u;
        return {std::popcount(low & high), std::popcount(low ^ high)};
    }
    /// A float and a byte of children, for every node.
    Children read_full()
    {
        need(5);
        float log_odds;
        std::memcpy(&log_odds, source_.bytes.data() + at_, 4);
        if (!std::isfinite(log_odds)) source_.fail("damaged: an occupancy is not finite");
        const auto children = static_cast<unsigned char>(source_.bytes[at_ + 4]);
        at_ += 5;
        return {std::popcount(children), 0};
    }

    const MeshSource& source_;
    std::size_t at_;
    bool binary_;
};

} // namespace

OctomapScan scan_octomap(const std::string& name, std::string_view bytes, bool binary)
{
    const MeshSource source{name, bytes};
    const Header header = read_header(source, binary);
    if (header.nodes == 0) source.fail("the map is empty");
    if (header.nodes > most_nodes)
        source.fail(fmt::format("the map has {} nodes; at most {} are allowed", header.nodes, most_nodes));
    const std::int64_t nodes = NodeWalk(source, header.bytes, binary).count();
    if (nodes != header.nodes)
        source.fail(fmt::format("damaged: the header announces {} nodes, but there are {}", header.nodes, nodes));
    return {header.resolution, header.bytes};
}

} // namespace oncollide
