#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

namespace oncollide {

/// Names of a file's nodes and the paths to them. Both are of bounded length: a kilobyte may instance one node of a
/// long name a hundred thousand times, and nest it. Private to scenes.
class NodePaths {
public:
    static constexpr std::size_t most_name = 200, most_path = 1000; ///< bytes

    /// @param above    for each node, the parent node or no_node
    /// @param name_of  empty: the node has no name
    /// @param parts    parts of the file; if there are many, paths have fewer levels
    NodePaths(std::span<const std::uint32_t> above, std::function<std::string_view(std::uint32_t)> name_of,
              std::size_t parts)
        : above_(above), name_of_(std::move(name_of)), levels_(parts <= 100'000 ? 64 : 8)
    {
    }

    /// "node 17" without a name; for a name longer than most_name, its two ends.
    std::string name(std::uint32_t node) const;
    /// The names of the nearest ancestors and the node's own name, as many as most_path bytes and the levels allow.
    std::string path(std::uint32_t node) const;

private:
    std::span<const std::uint32_t> above_;
    std::function<std::string_view(std::uint32_t)> name_of_;
    int levels_;
};

} // namespace oncollide
