#include <oncollide/narrowphase/gl/heap.hpp>

#include <algorithm>
#include <bit>
#include <iterator>

namespace oncollide::gl {

std::optional<std::size_t> Heap::add(std::size_t count)
{
    const auto fits = [&] {
        return std::find_if(free_.begin(), free_.end(), [&](const auto& range) { return range.second >= count; });
    };
    auto range = fits();
    if (range == free_.end()) {
        if (!enlarge(count)) return {};
        range = fits();
    }
    const auto [first, length] = *range;
    free_.erase(range);
    if (length > count) free_.emplace(first + count, length - count);
    used_ += count;
    return first;
}

bool Heap::enlarge(std::size_t count)
{
    const std::size_t room = std::min(std::max(std::bit_ceil(room_ + count), std::size_t{4096}), most_);
    if (room < room_ + count) return false;
    Buffer larger(room * unit_, 0);
    if (room_ > 0)
        glCopyNamedBufferSubData(buffer_.name(), larger.name(), 0, 0, static_cast<GLsizeiptr>(room_ * unit_));
    buffer_ = std::move(larger);
    const std::size_t first = room_;
    used_ += room - room_;
    room_ = room;
    remove(first, room - first);
    return true;
}

void Heap::remove(std::size_t first, std::size_t count)
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
