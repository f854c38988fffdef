#include <oncollide/narrowphase/gl/resources.hpp>

#include <bit>

#include <fmt/format.h>

#include <oncollide/narrowphase/spheres/occlusion_backend.hpp>

namespace oncollide::gl {

namespace {

std::string log_of(GLuint name, bool program)
{
    char text[2048] = "";
    (program ? glGetProgramInfoLog : glGetShaderInfoLog)(name, sizeof text, nullptr, text);
    return text;
}

} // namespace

void MappedBuffer::make_room(std::size_t bytes, const char* what)
{
    if (buffer_.bytes() >= bytes) return;
    buffer_ = Buffer(std::bit_ceil(bytes), flags_);
    data_ = static_cast<std::byte*>(
        glMapNamedBufferRange(buffer_.name(), 0, static_cast<GLsizeiptr>(buffer_.bytes()), flags_));
    if (!data_) throw GpuLost(fmt::format("{}: {} bytes cannot be mapped", what, buffer_.bytes()));
}

Program::Program(const char* what, std::initializer_list<Shader> shaders) : name_(glCreateProgram())
{
    for (const Shader& shader : shaders) {
        const GLuint compiled = glCreateShader(shader.stage);
        const char* source = shader.source.c_str();
        glShaderSource(compiled, 1, &source, nullptr);
        glCompileShader(compiled);
        GLint good = GL_FALSE;
        glGetShaderiv(compiled, GL_COMPILE_STATUS, &good);
        const std::string log = good ? "" : log_of(compiled, false);
        glAttachShader(name_, compiled);
        glDeleteShader(compiled); // the program keeps the shader
        if (!good) {
            glDeleteProgram(name_);
            throw GpuLost(fmt::format("{}: the driver cannot compile its shader: {}", what, log));
        }
    }
    glLinkProgram(name_);
    GLint good = GL_FALSE;
    glGetProgramiv(name_, GL_LINK_STATUS, &good);
    if (good) return;
    const std::string log = log_of(name_, true);
    glDeleteProgram(name_);
    throw GpuLost(fmt::format("{}: the driver cannot link its shaders: {}", what, log));
}

} // namespace oncollide::gl
