#include <oncollide/narrowphase/gl/primitive_store.hpp>

#include <algorithm>
#include <bit>
#include <iterator>

#include <oncollide/narrowphase/gl/list_store.hpp>

namespace oncollide::gl {

std::size_t PrimitiveStore::add(std::span<const Primitive> primitives)
{
    const std::size_t count = std::max<std::size_t>(primitives.size(), 1);
    const auto fits = [&] {
        return std::find_if(free_.begin(), free_.end(), [&](const auto& range) { return range.second >= count; });
    };
    auto range = fits();
    if (range == free_.end()) {
        const std::size_t room = buffer_.bytes() / sizeof(Primitive), most = most_ / sizeof(Primitive);
        const std::size_t wanted = std::min(std::max(std::bit_ceil(room + count), std::size_t{4096}), most);
        if (wanted < room + count) return no_room;
        grow(buffer_, wanted * sizeof(Primitive), buffer_.bytes(), wanted * sizeof(Primitive), "surfaces");
        remove(room, wanted - room), used_ += wanted - room; // the new room is free, and was not in use before
        range = fits();
    }
    const auto [first, length] = *range;
    free_.erase(range);
    if (length > count) free_.emplace(first + count, length - count);
    used_ += count;
    if (!primitives.empty()) {
        const Buffer uploaded(primitives.size_bytes(), 0, primitives.data());
        glCopyNamedBufferSubData(uploaded.name(), buffer_.name(), 0, static_cast<GLintptr>(first * sizeof(Primitive)),
                                 static_cast<GLsizeiptr>(primitives.size_bytes()));
    }
    return first;
}

void PrimitiveStore::remove(std::size_t first, std::size_t count)
{
    used_ -= count;
    const auto next = free_.lower_bound(first);
    if (next != free_.end() && first + count == next->first) {
        count += next->second;
        free_.erase(next);
    }
    const auto after = free_.lower_bound(first);
    if (after != free_.begin())
        if (const auto before = std::prev(after); before->first + before->second == first) {
            before->second += count;
            return;
        }
    free_.emplace(first, count);
}

} // namespace oncollide::gl
