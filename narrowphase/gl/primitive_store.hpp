#pragma once
#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>

#include <oncollide/narrowphase/gl/heap.hpp>
#include <oncollide/narrowphase/spheres/primitive.hpp>

namespace oncollide::gl {

/// The primitives of all surfaces in one buffer.
class PrimitiveStore {
public:
    explicit PrimitiveStore(std::size_t most_bytes) : heap_(sizeof(Primitive), most_bytes) {}

    /// Uploads a surface. Returns the number of its first primitive; none: there is no room.
    std::optional<std::size_t> add(std::span<const Primitive> primitives);
    /// @param count  as many as were added
    void remove(std::size_t first, std::size_t count) { heap_.remove(first, room_for(count)); }
    const Buffer& buffer() const { return heap_.buffer(); }
    std::size_t bytes() const { return heap_.bytes(); }

private:
    /// A surface without primitives has a place, too.
    static std::size_t room_for(std::size_t count) { return std::max<std::size_t>(count, 1); }

    Heap heap_; ///< units: primitives
};

} // namespace oncollide::gl
