#include <oncollide/pipeline/obb_trees.hpp>

namespace oncollide {

bool ObbTrees::admit(GeometryId geometry, std::uint32_t frame, const Room& room)
{
    Tree& tree = trees_[index(geometry)];
    tree.used = frame;
    if (tree.tree) return true;
    const auto* mesh = std::get_if<Mesh>(&scene_.geometries[index(geometry)].data);
    if (!mesh) return false;
    const Room more = most(*mesh);
    if (more.nodes > room.nodes || more.bytes > room.bytes) return false;
    tree.tree = std::make_unique<ObbTree>(*mesh);
    live_.push_back(index(geometry));
    reserved_.nodes += more.nodes, reserved_.bytes += more.bytes;
    return true;
}

std::uint64_t ObbTrees::drop(std::uint32_t frame, std::uint32_t age)
{
    std::uint64_t dropped = 0;
    std::erase_if(live_, [&](std::uint32_t geometry) {
        Tree& tree = trees_[geometry];
        if (frame - tree.used < age) return false;
        const Room less = most(tree.tree->mesh());
        reserved_.nodes -= less.nodes, reserved_.bytes -= less.bytes;
        dropped += tree.tree->nodes();
        tree.tree.reset();
        return true;
    });
    return dropped;
}

std::uint64_t ObbTrees::nodes() const
{
    std::uint64_t sum = 0;
    for (std::uint32_t geometry : live_) sum += trees_[geometry].tree->nodes();
    return sum;
}

std::size_t ObbTrees::bytes() const
{
    std::size_t sum = 0;
    for (std::uint32_t geometry : live_) sum += trees_[geometry].tree->bytes();
    return sum;
}

} // namespace oncollide
