#include "render/flat_picture.hpp"
#include "render/shading.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

/// Colours and depths of all samples.
struct Canvas {
    int width, height;
    std::vector<Colour> colours;
    std::vector<double> nearness; ///< 1 / distance along the view, which is linear on the screen

    Canvas(int w, int h, Colour background)
        : width(w), height(h), colours(std::size_t(w) * std::size_t(h), background), nearness(colours.size(), 0)
    {
    }
};

/// @param p  corners in samples from the upper left; z is the nearness
void fill(Canvas& canvas, const std::array<Vector3d, 3>& p, Colour colour)
{
    const auto side = [](const Vector3d& a, const Vector3d& b, double x, double y) {
        return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
    };
    const double area = side(p[0], p[1], p[2].x(), p[2].y());
    if (area == 0) return;
    const auto [left, right] = std::minmax({p[0].x(), p[1].x(), p[2].x()});
    const auto [top, bottom] = std::minmax({p[0].y(), p[1].y(), p[2].y()});
    const int x0 = int(std::clamp(std::floor(left), 0.0, double(canvas.width)));
    const int x1 = int(std::clamp(std::ceil(right), 0.0, double(canvas.width)));
    const int y0 = int(std::clamp(std::floor(top), 0.0, double(canvas.height)));
    const int y1 = int(std::clamp(std::ceil(bottom), 0.0, double(canvas.height)));
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
            Vector3d share;
            for (std::size_t k = 0; k < 3; ++k)
                share[Eigen::Index(k)] = side(p[(k + 1) % 3], p[(k + 2) % 3], x + 0.5, y + 0.5) / area;
            if (share.minCoeff() < 0) continue;
            const double nearness = share.dot(Vector3d(p[0].z(), p[1].z(), p[2].z()));
            const std::size_t at = std::size_t(y) * std::size_t(canvas.width) + std::size_t(x);
            if (nearness > canvas.nearness[at]) canvas.nearness[at] = nearness, canvas.colours[at] = colour;
        }
}

} // namespace

Image draw_bodies(const Picture& picture)
{
    Canvas canvas(picture.width * samples_per_side, picture.height * samples_per_side, picture.background);
    const Eigen::Isometry3d view = view_of(picture.camera);
    const double scale = 0.5 * canvas.height / std::tan(0.5 * picture.camera.view_angle);
    std::vector<Vector3d> seen;
    for (const Picture::Body& body : picture.bodies) {
        seen.clear();
        for (const Vector3d& vertex : body.mesh->vertices) seen.push_back(view * (body.pose * vertex));
        for (const Triangle& triangle : body.mesh->triangles) {
            const Vector3d &a = seen[triangle[0]], &b = seen[triangle[1]], &c = seen[triangle[2]];
            if (std::max({a.z(), b.z(), c.z()}) >= 0) continue;
            const Vector3d normal = (b - a).cross(c - a), middle = (a + b + c) / 3;
            const double length = normal.norm() * middle.norm();
            if (length == 0) continue;
            std::array<Vector3d, 3> corners{a, b, c};
            for (Vector3d& p : corners) {
                const double nearness = -1 / p.z();
                p = {0.5 * canvas.width + scale * p.x() * nearness, 0.5 * canvas.height - scale * p.y() * nearness,
                     nearness};
            }
            fill(canvas, corners, lit(body.colour, light_of(normal.dot(middle) / length)));
        }
    }
    Image image{picture.width, picture.height, {}};
    image.pixels.resize(3 * std::size_t(image.width) * std::size_t(image.height));
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            std::array<Colour, samples_per_pixel> samples;
            for (int k = 0; k < int(samples_per_pixel); ++k) {
                const int row = y * samples_per_side + k / samples_per_side;
                const int column = x * samples_per_side + k % samples_per_side;
                samples[std::size_t(k)] =
                    canvas.colours[std::size_t(row) * std::size_t(canvas.width) + std::size_t(column)];
            }
            image.set(x, y, mean(samples));
        }
    return image;
}

} // namespace oncollide::tools
