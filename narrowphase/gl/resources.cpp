#include <oncollide/narrowphase/gl/resources.hpp>

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
