#pragma once
#include <cstddef>
#include <map>
#include <optional>

#include <oncollide/narrowphase/gl/resources.hpp>

namespace oncollide::gl {

/// A buffer of which ranges are in use. First-fit allocation; a freed range merges with its neighbours. Ranges keep
/// their place and content when the buffer grows.
class Heap {
public:
    /// @param unit  bytes; ranges are multiples of it
    Heap(std::size_t unit, std::size_t most_bytes) : unit_(unit), most_(most_bytes / unit) {}

    /// The first unit of a new range; none: there is no room. Its content is undefined.
    std::optional<std::size_t> add(std::size_t count);
    void remove(std::size_t first, std::size_t count);
    const Buffer& buffer() const { return buffer_; }
    std::size_t bytes() const { return used_ * unit_; }

private:
    bool enlarge(std::size_t count);

    std::size_t unit_, most_;
    Buffer buffer_;
    std::size_t room_ = 0, used_ = 0;         ///< units
    std::map<std::size_t, std::size_t> free_; ///< first -> count
};

} // namespace oncollide::gl
