#include <oncollide/narrowphase/gl/octant_queries.hpp>

namespace oncollide::gl {

namespace {

// An octant and its view volume have the same centre, so clip coordinates are the octant's coordinates, and the view
// along an axis is a permutation that puts this axis last. Seen from the opposite side or mirrored, the mesh covers the
// same number of pixels.
constexpr const char* vertex_shader = R"(#version 430 core
layout(location = 0) in vec3 position;
layout(location = 0) uniform vec3 centre;
layout(location = 1) uniform vec3 half_extents;
layout(location = 2) uniform int axis;
void main()
{
    vec3 p = (position - centre) / half_extents;
    gl_Position = vec4(axis == 0 ? p.yzx : axis == 1 ? p.zxy : p, 1.0);
}
)";
constexpr const char* fragment_shader = "#version 430 core\nvoid main() {}\n";

} // namespace

BareFramebuffer::BareFramebuffer(int pixels)
{
    glCreateFramebuffers(1, &name_);
    glNamedFramebufferParameteri(name_, GL_FRAMEBUFFER_DEFAULT_WIDTH, pixels);
    glNamedFramebufferParameteri(name_, GL_FRAMEBUFFER_DEFAULT_HEIGHT, pixels);
}

Queries::Queries(GLenum target, std::size_t count)
    : names_(count), results_(count * sizeof(GLuint), GL_DYNAMIC_STORAGE_BIT)
{
    glCreateQueries(target, static_cast<GLsizei>(count), names_.data());
}

std::span<const GLuint> Queries::read(std::size_t count)
{
    // The results go into a buffer first, so that there is one wait instead of one per query.
    for (std::size_t i = 0; i < count; ++i)
        glGetQueryBufferObjectuiv(names_[i], results_.name(), GL_QUERY_RESULT,
                                  static_cast<GLintptr>(i * sizeof(GLuint)));
    samples_.resize(count);
    glGetNamedBufferSubData(results_.name(), 0, static_cast<GLsizeiptr>(count * sizeof(GLuint)), samples_.data());
    return samples_;
}

OctantQueries::OctantQueries(GLenum target, int viewport, bool inflated)
    : target_(target), growth_(inflated ? 1 + 1 / static_cast<float>(viewport) : 1),
      program_("gl-query", {{GL_VERTEX_SHADER, vertex_shader}, {GL_FRAGMENT_SHADER, fragment_shader}}),
      framebuffer_(viewport), queries_(target, most_in_flight)
{
    glUseProgram(program_.name());
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
    glViewport(0, 0, viewport, viewport);
    glEnable(GL_PRIMITIVE_RESTART_FIXED_INDEX);
}

void OctantQueries::look_along(int axis)
{
    glUniform1i(2, axis);
}

void OctantQueries::look_at(const OctantCell& octant)
{
    glUniform3fv(0, 1, octant.centre);
    glUniform3f(1, octant.half[0] * growth_, octant.half[1] * growth_, octant.half[2] * growth_);
}

} // namespace oncollide::gl
