#pragma once
#include <cstddef>
#include <vector>

#include <epoxy/gl.h>

namespace oncollide::gl {

// Objects whose context must be current when they are made and die.

/// A square framebuffer that stores nothing: fragments are only counted.
class BareFramebuffer {
public:
    explicit BareFramebuffer(int pixels)
    {
        glCreateFramebuffers(1, &name_);
        glNamedFramebufferParameteri(name_, GL_FRAMEBUFFER_DEFAULT_WIDTH, pixels);
        glNamedFramebufferParameteri(name_, GL_FRAMEBUFFER_DEFAULT_HEIGHT, pixels);
    }
    ~BareFramebuffer() { glDeleteFramebuffers(1, &name_); }
    BareFramebuffer(const BareFramebuffer&) = delete;
    BareFramebuffer& operator=(const BareFramebuffer&) = delete;
    GLuint name() const { return name_; }

private:
    GLuint name_ = 0;
};

/// Query objects, all of one target: a query object cannot change it.
class Queries {
public:
    Queries(GLenum target, std::size_t count) : names_(count)
    {
        glCreateQueries(target, static_cast<GLsizei>(count), names_.data());
    }
    ~Queries() { glDeleteQueries(static_cast<GLsizei>(names_.size()), names_.data()); }
    Queries(const Queries&) = delete;
    Queries& operator=(const Queries&) = delete;
    GLuint operator[](std::size_t i) const { return names_[i]; }

private:
    std::vector<GLuint> names_;
};

} // namespace oncollide::gl
