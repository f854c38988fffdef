#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include <oncollide/narrowphase/gl/resources.hpp>
#include <oncollide/narrowphase/spheres/octant_kernel.hpp>

namespace oncollide::gl {

// The context of these objects must be current whenever they are used or destroyed.

/// A square framebuffer without storage: fragments are only counted.
class BareFramebuffer {
public:
    explicit BareFramebuffer(int pixels);
    ~BareFramebuffer() { glDeleteFramebuffers(1, &name_); }
    BareFramebuffer(const BareFramebuffer&) = delete;
    BareFramebuffer& operator=(const BareFramebuffer&) = delete;
    GLuint name() const { return name_; }

private:
    GLuint name_ = 0;
};

/// Query objects of one target, which a query object cannot change.
class Queries {
public:
    Queries(GLenum target, std::size_t count);
    /// Waits for the first `count` queries. Returns their results, 0 for no fragment; valid until the next read().
    std::span<const GLuint> read(std::size_t count);
    ~Queries() { glDeleteQueries(static_cast<GLsizei>(names_.size()), names_.data()); }
    Queries(const Queries&) = delete;
    Queries& operator=(const Queries&) = delete;
    GLuint operator[](std::size_t i) const { return names_[i]; }
    std::size_t size() const { return names_.size(); }

private:
    std::vector<GLuint> names_, samples_;
    Buffer results_;
};

/// Occlusion queries whose view volume is an octant, many in flight. They need a context of their own: OpenGL's state
/// is set only once.
class OctantQueries {
public:
    static constexpr std::size_t most_in_flight = 4096;

    /// @param target    GL_SAMPLES_PASSED or GL_ANY_SAMPLES_PASSED
    /// @param viewport  pixels per side
    /// @param inflated  view volumes half a texel larger on every side
    OctantQueries(GLenum target, int viewport, bool inflated);

    void look_along(int axis);
    /// Issues query number i, below most_in_flight: whether draw() leaves a fragment in the octant.
    template <class Draw>
    void issue(std::size_t i, const OctantCell& octant, Draw draw)
    {
        look_at(octant);
        glBeginQuery(target_, queries_[i]);
        draw();
        glEndQuery(target_);
    }
    std::span<const GLuint> read(std::size_t count) { return queries_.read(count); }

private:
    void look_at(const OctantCell& octant);

    GLenum target_;
    float growth_; ///< relative size of the view volumes
    Program program_;
    BareFramebuffer framebuffer_;
    Queries queries_;
};

} // namespace oncollide::gl
