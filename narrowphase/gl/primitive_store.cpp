#include <oncollide/narrowphase/gl/primitive_store.hpp>

namespace oncollide::gl {

std::optional<std::size_t> PrimitiveStore::add(std::span<const Primitive> primitives)
{
    const std::optional<std::size_t> first = heap_.add(room_for(primitives.size()));
    if (first && !primitives.empty()) {
        const Buffer uploaded(primitives.size_bytes(), 0, primitives.data());
        glCopyNamedBufferSubData(uploaded.name(), buffer().name(), 0, static_cast<GLintptr>(*first * sizeof(Primitive)),
                                 static_cast<GLsizeiptr>(primitives.size_bytes()));
    }
    return first;
}

} // namespace oncollide::gl
