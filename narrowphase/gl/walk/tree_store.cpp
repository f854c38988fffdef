#include <oncollide/narrowphase/gl/walk/tree_store.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

#include <oncollide/narrowphase/gl/list_store.hpp>

namespace oncollide::gl::walk {

namespace {

constexpr std::size_t line_words = sizeof(NodeLine) / 4;

/// Floats and the squares and products of a walk stay in their range.
bool in_range(const ObbTree& tree)
{
    return tree.radius() > 0x1p-40 && tree.radius() < 0x1p40 && tree.centre().cwiseAbs().maxCoeff() < 0x1p60;
}

} // namespace

TreeStore::TreeStore(std::size_t most_bytes)
    : most_(most_bytes), words_(4, most_bytes), vertices_(3 * sizeof(double), most_bytes)
{
}

std::optional<std::uint32_t> TreeStore::hold(const ObbTree& tree, std::uint32_t frame)
{
    if (tree.chunked() || tree.deformed() || !in_range(tree)) return {};
    const auto known = slots_.find(tree.identity());
    if (known != slots_.end() && held_[known->second].nodes == tree.nodes()) {
        held_[known->second].frame = frame;
        return known->second;
    }
    if (tree.nodes() < 2 && !tree.node(ObbTree::root).leaves) return {};
    if (refused_.contains(tree.identity())) return {};
    if (known != slots_.end()) {
        Held& held = held_[known->second];
        held.frame = frame;
        update(held, tree);
        return known->second;
    }
    const std::uint32_t slot = free_slot();
    Held& held = held_[slot];
    held.identity = tree.identity(), held.frame = frame;
    if (!add(held, tree)) {
        drop(held), refused_.insert(tree.identity());
        return {};
    }
    slots_.emplace(tree.identity(), slot);
    return slot;
}

std::uint32_t TreeStore::free_slot()
{
    if (!free_.empty()) {
        const std::uint32_t slot = free_.back();
        free_.pop_back();
        return slot;
    }
    table_.emplace_back(), held_.emplace_back();
    return static_cast<std::uint32_t>(held_.size() - 1);
}

bool TreeStore::add(Held& held, const ObbTree& tree)
{
    const Mesh& mesh = tree.mesh();
    const std::size_t triangles = mesh.triangles.size();
    const auto fixed = words_.add(4 * triangles);
    if (!fixed) return false;
    held.fixed = *fixed, held.fixed_count = 4 * triangles;
    const auto vertices = vertices_.add(mesh.vertices.size());
    if (!vertices) return false;
    held.vertices = *vertices, held.vertex_count = mesh.vertices.size();
    put_words(held.fixed + triangles, mesh.triangles.data(), 3 * triangles);
    put(&vertices_, 3 * sizeof(double) * held.vertices, mesh.vertices.data(),
        3 * sizeof(double) * mesh.vertices.size());
    return update(held, tree);
}

/// Copies the parts of the tree that grew. Returns false if there is no copy.
bool TreeStore::update(Held& held, const ObbTree& tree)
{
    const std::uint32_t nodes = tree.nodes(); // it may grow meanwhile; the rest follows the next time
    tree.copy_growth(held.lines, growth_);
    held.nodes = nodes;
    if (const std::size_t words = growth_.lines * line_words; words > held.room) {
        const std::size_t room = std::max<std::size_t>(words + words / 2, 8 * line_words);
        const auto first = words_.add(room);
        if (first) tree.copy_growth(0, growth_);
        if (!first || growth_.lines * line_words > room) { // no room, or other threads grew it in this moment
            if (first) words_.remove(*first, room);
            return held.lines > 0; // an old copy stays, as pairs of this batch may use it; it only lacks nodes
        }
        if (held.room) words_.remove(held.first, held.room);
        held.first = *first, held.room = room;
    }
    held.lines = growth_.lines;
    put_words(held.first + growth_.from * line_words, growth_.added.data(), growth_.added.size() * line_words);
    for (std::size_t i = 0; i < growth_.changed.size(); ++i)
        put_words(held.first + growth_.changed[i] * line_words, &growth_.contents[i], line_words);
    const std::uint32_t* order = growth_.order.data();
    for (const TreeGrowth::Range& range : growth_.sorted) {
        put_words(held.fixed + range.begin, order, range.count);
        order += range.count;
    }
    const auto slot = static_cast<std::size_t>(&held - held_.data());
    GpuTree& entry = table_[slot];
    entry = {};
    std::copy_n(tree.centre().data(), 3, entry.centre);
    entry.radius = tree.radius();
    entry.nodes = static_cast<std::uint32_t>(held.first), entry.order = static_cast<std::uint32_t>(held.fixed);
    entry.triangles = static_cast<std::uint32_t>(held.fixed + held.fixed_count / 4);
    entry.vertices = static_cast<std::uint32_t>(held.vertices);
    put(nullptr, slot * sizeof(GpuTree), &entry, sizeof entry);
    return true;
}

void TreeStore::drop(Held& held)
{
    if (held.room) words_.remove(held.first, held.room);
    if (held.fixed_count) words_.remove(held.fixed, held.fixed_count);
    if (held.vertex_count) vertices_.remove(held.vertices, held.vertex_count);
    slots_.erase(held.identity);
    free_.push_back(static_cast<std::uint32_t>(&held - held_.data()));
    held = {};
}

void TreeStore::drop_unused(std::uint32_t frame)
{
    for (Held& held : held_)
        if (held.identity && held.frame < frame) drop(held), refused_.clear();
}

void TreeStore::put(const Heap* to, std::size_t byte, const void* data, std::size_t bytes)
{
    if (bytes == 0) return;
    copies_.push_back({to, staged_.size(), byte, bytes});
    staged_.resize(staged_.size() + bytes);
    std::memcpy(staged_.data() + copies_.back().from, data, bytes);
}

std::size_t TreeStore::upload()
{
    const std::size_t bytes = staged_.size();
    grow(trees_, std::max<std::size_t>(table_.size(), 64) * sizeof(GpuTree), trees_.bytes(), most_,
         "the table of trees");
    if (bytes == 0) return 0;
    const Buffer uploaded(bytes, 0, staged_.data());
    for (const Copy& copy : copies_)
        glCopyNamedBufferSubData(uploaded.name(), (copy.to ? copy.to->buffer() : trees_).name(),
                                 static_cast<GLintptr>(copy.from), static_cast<GLintptr>(copy.at),
                                 static_cast<GLsizeiptr>(copy.bytes));
    copies_.clear(), staged_.clear();
    return bytes;
}

void TreeStore::bind() const
{
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, slot::words, words_.buffer().name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, slot::vertices, vertices_.buffer().name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, slot::trees, trees_.name());
}

} // namespace oncollide::gl::walk
