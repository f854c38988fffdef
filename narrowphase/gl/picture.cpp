#include <oncollide/narrowphase/gl/picture.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>

#include <oncollide/narrowphase/gl/context.hpp>
#include <oncollide/narrowphase/gl/picture_shaders.hpp>
#include <oncollide/narrowphase/gl/resources.hpp>

namespace oncollide {

namespace {

using gl::Buffer;

/// Layouts in which the vertex shaders read their input.
struct Corner {
    Eigen::Vector3f position, normal;
};
struct BallInstance {
    Eigen::Vector3f centre; ///< view frame
    float radius;
    Colour colour;
};
struct LineInstance {
    Eigen::Vector3f from, to; ///< view frame
    float width;
    Colour colour;
};

/// The layout of one kind of vertex in its buffer. Its context must be current whenever it is used or destroyed.
class VertexLayout {
public:
    VertexLayout() { glCreateVertexArrays(1, &name_); }
    ~VertexLayout() { glDeleteVertexArrays(1, &name_); }
    VertexLayout(const VertexLayout&) = delete;
    VertexLayout& operator=(const VertexLayout&) = delete;

    void add(GLuint location, GLint size, GLenum type, std::size_t offset)
    {
        glEnableVertexArrayAttrib(name_, location);
        glVertexArrayAttribFormat(name_, location, size, type, type == GL_UNSIGNED_BYTE, GLuint(offset));
        glVertexArrayAttribBinding(name_, location, 0);
    }
    void one_an_instance() { glVertexArrayBindingDivisor(name_, 0, 1); }
    void use(const Buffer& buffer, std::size_t stride)
    {
        glVertexArrayVertexBuffer(name_, 0, buffer.name(), 0, GLsizei(stride));
        glBindVertexArray(name_);
    }

private:
    GLuint name_ = 0;
};

/// A framebuffer with colour and depth, `samples` per pixel.
class Canvas {
public:
    Canvas(int width, int height, int samples)
    {
        glCreateFramebuffers(1, &name_);
        glCreateRenderbuffers(2, parts_);
        const GLenum formats[] = {GL_RGBA8, GL_DEPTH_COMPONENT32F};
        const GLenum places[] = {GL_COLOR_ATTACHMENT0, GL_DEPTH_ATTACHMENT};
        for (int i = 0; i < 2; ++i) {
            glNamedRenderbufferStorageMultisample(parts_[i], samples, formats[i], width, height);
            glNamedFramebufferRenderbuffer(name_, places[i], GL_RENDERBUFFER, parts_[i]);
        }
    }
    ~Canvas() { glDeleteFramebuffers(1, &name_), glDeleteRenderbuffers(2, parts_); }
    Canvas(const Canvas&) = delete;
    Canvas& operator=(const Canvas&) = delete;
    GLuint name() const { return name_; }

private:
    GLuint name_ = 0, parts_[2] = {};
};

/// Corners of a mesh, relative to the centre of its bounds, so that meshes far from their origin keep their shape in
/// float.
Buffer upload(const Mesh& mesh)
{
    std::vector<Corner> corners;
    corners.reserve(3 * mesh.triangles.size());
    const Eigen::Vector3d centre = mesh.bounds.centre();
    for (const Triangle& t : mesh.triangles) {
        const Eigen::Vector3d p = mesh.vertices[t[0]], q = mesh.vertices[t[1]], r = mesh.vertices[t[2]];
        const Eigen::Vector3f normal = (q - p).cross(r - p).stableNormalized().cast<float>();
        for (const Eigen::Vector3d& corner : {p, q, r}) corners.push_back({(corner - centre).cast<float>(), normal});
    }
    return Buffer(corners.size() * sizeof(Corner), 0, corners.data());
}

/// Spheres in the view frame: opaque ones first, then bubbles from far to near. Returns the number of opaque ones.
std::size_t order(const Picture& picture, const Eigen::Isometry3d& view, std::vector<BallInstance>& balls)
{
    for (const Picture::Ball& ball : picture.balls)
        balls.push_back({(view * ball.centre).cast<float>(), float(ball.radius), ball.colour});
    const auto bubbles = std::stable_partition(balls.begin(), balls.end(),
                                               [](const BallInstance& ball) { return ball.colour.alpha == 255; });
    std::stable_sort(bubbles, balls.end(), [](const BallInstance& a, const BallInstance& b) {
        return a.centre.squaredNorm() > b.centre.squaredNorm();
    });
    return std::size_t(bubbles - balls.begin());
}

/// Near and far planes around all objects, so that depth is as fine as possible.
std::pair<double, double> depth_range(const Picture& picture, const Eigen::Isometry3d& view)
{
    double near = std::numeric_limits<double>::infinity(), far = 0;
    const auto add = [&](const Eigen::Vector3d& p, double radius) {
        const double depth = -(view * p).z();
        near = std::min(near, depth - radius), far = std::max(far, depth + radius);
    };
    for (const Picture::Body& body : picture.bodies)
        add(body.pose * body.mesh->bounds.centre(), 0.5 * body.mesh->bounds.diagonal());
    for (const Picture::Ball& ball : picture.balls) add(ball.centre, ball.radius);
    if (!(far > 0)) return {0.1, 1}; // nothing in front of the eye
    return {std::max(0.99 * near, 1e-4 * far), 1.01 * far};
}

Eigen::Matrix4f projection_of(const Picture& picture, const Eigen::Isometry3d& view)
{
    const auto [near, far] = depth_range(picture, view);
    const double y = 1 / std::tan(0.5 * picture.camera.view_angle), x = y * picture.height / picture.width;
    Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
    m(0, 0) = x, m(1, 1) = y, m(2, 2) = (near + far) / (near - far), m(2, 3) = 2 * near * far / (near - far);
    m(3, 2) = -1;
    return m.cast<float>();
}

} // namespace

/// The objects that one context needs for any number of pictures.
struct Painter::Tools {
    explicit Tools(int gpu) : context(gpu)
    {
        corners.add(0, 3, GL_FLOAT, offsetof(Corner, position));
        corners.add(1, 3, GL_FLOAT, offsetof(Corner, normal));
        balls.add(0, 4, GL_FLOAT, offsetof(BallInstance, centre));
        balls.add(1, 4, GL_UNSIGNED_BYTE, offsetof(BallInstance, colour));
        balls.one_an_instance();
        lines.add(0, 3, GL_FLOAT, offsetof(LineInstance, from));
        lines.add(1, 3, GL_FLOAT, offsetof(LineInstance, to));
        lines.add(2, 1, GL_FLOAT, offsetof(LineInstance, width));
        lines.add(3, 4, GL_UNSIGNED_BYTE, offsetof(LineInstance, colour));
        lines.one_an_instance();
    }

    gl::Context context;
    gl::Program mesh_program{
        "picture",
        {{GL_VERTEX_SHADER, gl::mesh_vertex}, {GL_FRAGMENT_SHADER, std::string(gl::shading) + gl::mesh_fragment}}};
    gl::Program ball_program{
        "picture",
        {{GL_VERTEX_SHADER, gl::ball_vertex}, {GL_FRAGMENT_SHADER, std::string(gl::shading) + gl::ball_fragment}}};
    gl::Program line_program{"picture", {{GL_VERTEX_SHADER, gl::line_vertex}, {GL_FRAGMENT_SHADER, gl::line_fragment}}};
    VertexLayout corners, balls, lines;

    void begin(const Picture& picture, const Canvas& canvas);
    void draw_bodies(const Picture& picture, const Eigen::Isometry3d& view, const Eigen::Matrix4f& projection,
                     bool glass);
    void draw_glass(const Picture& picture, const Eigen::Isometry3d& view, const Eigen::Matrix4f& projection);
    void draw_balls(const Picture& picture, const Eigen::Isometry3d& view, const Eigen::Matrix4f& projection);
    void draw_lines(const Picture& picture, const Eigen::Isometry3d& view, const Eigen::Matrix4f& projection);
};

void Painter::Tools::begin(const Picture& picture, const Canvas& canvas)
{
    glBindFramebuffer(GL_FRAMEBUFFER, canvas.name());
    glViewport(0, 0, picture.width, picture.height);
    const Colour& c = picture.background;
    glClearColor(float(c.red) / 255, float(c.green) / 255, float(c.blue) / 255, 1);
    glDepthMask(GL_TRUE);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    // A sphere's outline is inside its square: it is smooth only if each sample is shaded separately.
    glEnable(GL_SAMPLE_SHADING);
    glMinSampleShading(1);
}

void Painter::Tools::draw_bodies(const Picture& picture, const Eigen::Isometry3d& view,
                                 const Eigen::Matrix4f& projection, bool glass)
{
    std::map<const Mesh*, Buffer> uploaded; // bodies with the same mesh share its buffer
    glUseProgram(mesh_program.name());
    glUniformMatrix4fv(1, 1, GL_FALSE, projection.data());
    for (const Picture::Body& body : picture.bodies) {
        if ((body.colour.alpha < 255) != glass) continue;
        auto place = uploaded.find(body.mesh);
        if (place == uploaded.end()) place = uploaded.emplace(body.mesh, upload(*body.mesh)).first;
        const Eigen::Isometry3d to_view = view * body.pose * Eigen::Translation3d(body.mesh->bounds.centre());
        const Eigen::Matrix4f matrix = to_view.matrix().cast<float>();
        glUniformMatrix4fv(0, 1, GL_FALSE, matrix.data());
        const Colour& c = body.colour;
        glUniform4f(2, float(c.red) / 255, float(c.green) / 255, float(c.blue) / 255, float(c.alpha) / 255);
        corners.use(place->second, sizeof(Corner));
        glDrawArrays(GL_TRIANGLES, 0, GLsizei(3 * body.mesh->triangles.size()));
    }
}

/// Blends transparent objects over the opaque ones, which must have been drawn.
void Painter::Tools::draw_glass(const Picture& picture, const Eigen::Isometry3d& view,
                                const Eigen::Matrix4f& projection)
{
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    glDepthMask(GL_FALSE);
    draw_bodies(picture, view, projection, true);
    glDisable(GL_BLEND);
}

void Painter::Tools::draw_balls(const Picture& picture, const Eigen::Isometry3d& view,
                                const Eigen::Matrix4f& projection)
{
    if (picture.balls.empty()) return;
    std::vector<BallInstance> instances;
    const std::size_t opaque = order(picture, view, instances);
    const Buffer buffer(instances.size() * sizeof(BallInstance), 0, instances.data());
    glUseProgram(ball_program.name());
    glUniformMatrix4fv(1, 1, GL_FALSE, projection.data());
    balls.use(buffer, sizeof(BallInstance));
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, GLsizei(opaque));

    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    glDepthMask(GL_FALSE);
    glDrawArraysInstancedBaseInstance(GL_TRIANGLE_STRIP, 0, 4, GLsizei(instances.size() - opaque), GLuint(opaque));
    glDisable(GL_BLEND);
}

void Painter::Tools::draw_lines(const Picture& picture, const Eigen::Isometry3d& view,
                                const Eigen::Matrix4f& projection)
{
    std::vector<LineInstance> instances;
    for (const Picture::Line& line : picture.lines) {
        const Eigen::Vector3d from = view * line.from, to = view * line.to;
        if (from.z() >= 0 || to.z() >= 0) continue;
        instances.push_back({from.cast<float>(), to.cast<float>(), float(line.width), line.colour});
    }
    if (instances.empty()) return;
    const Buffer buffer(instances.size() * sizeof(LineInstance), 0, instances.data());
    glUseProgram(line_program.name());
    glUniformMatrix4fv(1, 1, GL_FALSE, projection.data());
    glUniform2f(2, 0.5f * float(picture.width), 0.5f * float(picture.height));
    glDisable(GL_DEPTH_TEST);
    lines.use(buffer, sizeof(LineInstance));
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, GLsizei(instances.size()));
}

Painter::Painter(int gpu) : tools_(std::make_unique<Tools>(gpu))
{
    tools_->context.check("preparing to draw");
}

Painter::~Painter()
{
    tools_->context.use_at_end();
}

std::vector<std::uint8_t> Painter::draw(const Picture& picture)
{
    tools_->context.use();
    const Eigen::Isometry3d view = view_of(picture.camera);
    const Eigen::Matrix4f projection = projection_of(picture, view);
    const int width = picture.width, height = picture.height;
    const Canvas canvas(width, height, 4), resolved(width, height, 0);
    tools_->begin(picture, canvas);
    tools_->draw_bodies(picture, view, projection, false);
    tools_->draw_balls(picture, view, projection);
    tools_->draw_glass(picture, view, projection);
    tools_->draw_lines(picture, view, projection);
    glBlitNamedFramebuffer(canvas.name(), resolved.name(), 0, 0, width, height, 0, 0, width, height,
                           GL_COLOR_BUFFER_BIT, GL_NEAREST);

    const std::size_t row = 3 * std::size_t(width);
    std::vector<std::uint8_t> pixels(row * std::size_t(height));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, resolved.name());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
    tools_->context.check("drawing");
    for (int y = 0; y < height / 2; ++y) // OpenGL's rows start at the bottom
        std::swap_ranges(pixels.begin() + std::ptrdiff_t(row) * y, pixels.begin() + std::ptrdiff_t(row) * (y + 1),
                         pixels.end() - std::ptrdiff_t(row) * (y + 1));
    return pixels;
}

} // namespace oncollide
