#pragma once
#include <cstddef>
#include <map>
#include <span>

#include <oncollide/narrowphase/gl/resources.hpp>
#include <oncollide/narrowphase/spheres/primitive.hpp>

namespace oncollide::gl {

/// The primitives of all surfaces in one buffer. First-fit allocation; a freed range merges with its neighbours.
class PrimitiveStore {
public:
    explicit PrimitiveStore(std::size_t most_bytes) : most_(most_bytes) {}

    static constexpr std::size_t no_room = ~std::size_t{0};
    /// Uploads a surface. Returns the number of its first primitive, or no_room.
    std::size_t add(std::span<const Primitive> primitives);
    void remove(std::size_t first, std::size_t count);
    const Buffer& buffer() const { return buffer_; }
    std::size_t bytes() const { return used_ * sizeof(Primitive); }

private:
    std::size_t most_;
    Buffer buffer_;
    std::size_t used_ = 0;                    ///< primitives
    std::map<std::size_t, std::size_t> free_; ///< first -> count
};

} // namespace oncollide::gl
