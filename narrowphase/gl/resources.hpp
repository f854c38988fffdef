#pragma once
#include <cstddef>
#include <initializer_list>
#include <string>
#include <utility>

#include <epoxy/gl.h>

namespace oncollide::gl {

/// A buffer object. Its context must be current whenever it is used or destroyed.
class Buffer {
public:
    Buffer() = default;
    /// @param flags  the flags of glNamedBufferStorage; `data` may be null
    Buffer(std::size_t bytes, GLbitfield flags, const void* data = nullptr) : bytes_(bytes)
    {
        glCreateBuffers(1, &name_);
        glNamedBufferStorage(name_, static_cast<GLsizeiptr>(bytes), data, flags);
    }
    ~Buffer() { glDeleteBuffers(name_ != 0, &name_); }
    Buffer(Buffer&& other) noexcept { *this = std::move(other); }
    Buffer& operator=(Buffer&& other) noexcept
    {
        std::swap(name_, other.name_), std::swap(bytes_, other.bytes_);
        return *this;
    }
    GLuint name() const { return name_; }
    std::size_t bytes() const { return bytes_; }

private:
    GLuint name_ = 0;
    std::size_t bytes_ = 0;
};

/// A buffer that the CPU reads or writes in place while the GPU copies from or to it.
class MappedBuffer {
public:
    /// @param access  GL_MAP_READ_BIT or GL_MAP_WRITE_BIT
    explicit MappedBuffer(GLbitfield access) : flags_(access | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT) {}
    /// Makes the buffer at least `bytes` large; its content is lost. Throws GpuLost, which names `what`.
    void make_room(std::size_t bytes, const char* what);
    GLuint name() const { return buffer_.name(); }
    std::byte* data() const { return data_; }

private:
    GLbitfield flags_;
    Buffer buffer_;
    std::byte* data_ = nullptr;
};

/// A linked program of one or more shaders.
class Program {
public:
    struct Shader {
        GLenum stage;
        std::string source;
    };
    /// Throws GpuLost with the driver's message: a program that does not compile is useless.
    Program(const char* what, std::initializer_list<Shader> shaders);
    ~Program() { glDeleteProgram(name_); }
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;
    GLuint name() const { return name_; }

private:
    GLuint name_ = 0;
};

} // namespace oncollide::gl
