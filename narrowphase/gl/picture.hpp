#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// Values as in an image file, 0 to 255.
struct Colour {
    std::uint8_t red, green, blue;
    std::uint8_t alpha = 255; ///< 255: opaque
};

/// The viewpoint. z is up, or y for a view along z.
struct Camera {
    Eigen::Vector3d eye{0, -5, 0}, look_at{0, 0, 0}; ///< must differ
    double view_angle = 0.5;                         ///< radians, over the height of the picture
};

/// World frame to view frame: x to the right, y up, the eye at the origin looking along -z.
Eigen::Isometry3d view_of(const Camera& camera);

/// The scene to draw: meshes, spheres, and lines on top. All in the world frame, in double: only positions relative to
/// the eye are rounded.
struct Picture {
    struct Body {
        const Mesh* mesh; ///< must live until the picture is drawn
        Eigen::Isometry3d pose;
        Colour colour; ///< with alpha below 255 it looks like glass: clear where the view is straight at it
    };
    struct Ball {
        Eigen::Vector3d centre;
        double radius;
        Colour colour; ///< with alpha below 255 it looks like a soap bubble
    };
    /// Drawn on top of everything. Omitted if an end is behind the eye.
    struct Line {
        Eigen::Vector3d from, to; ///< may be equal: then the line is a dot
        double width;             ///< pixels
        Colour colour;            ///< always opaque
    };
    std::vector<Body> bodies;
    std::vector<Ball> balls;
    std::vector<Line> lines;
    Camera camera;
    int width = 640, height = 480; ///< pixels, each 1 to 8192
    Colour background{255, 255, 255};
};

/// Draws pictures on a GPU, or on a software renderer if there is none. Belongs to the thread that made it.
class Painter {
public:
    /// @param gpu  number in gpu_devices(); -1: the first hardware device, else software
    /// Throws Error{no_gpu}.
    explicit Painter(int gpu = -1);
    ~Painter();
    Painter(const Painter&) = delete;
    Painter& operator=(const Painter&) = delete;

    /// Returns red, green and blue of each pixel, rows from the top. Two lights move with the camera; four samples per
    /// pixel smooth edges. Opaque objects hide each other by depth; bubbles are blended over them, far ones first, then
    /// bodies of glass, in their order, then lines. Equal pictures give equal bytes on the same renderer. Throws
    /// GpuLost.
    std::vector<std::uint8_t> draw(const Picture& picture);

private:
    struct Tools;
    std::unique_ptr<Tools> tools_;
};

} // namespace oncollide
