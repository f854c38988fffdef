#include "render/ray_picture.hpp"
#include "common/statistics.hpp"
#include "render/shading.hpp"

#include <algorithm>
#include <cmath>

#include <oncollide/runs/deforming_models.hpp>

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

constexpr int band = 16;         ///< rows of pixels that are cast in one call
constexpr double far_away = 1e3; ///< metres of view into a scene of half-spaces alone

/// The eight corners of a geometry's AABB at a pose; none if it is unbounded.
std::vector<Vector3d> corners_of(const Geometry& geometry, const Eigen::Isometry3d& pose)
{
    const Aabb box = bounds_of(geometry);
    std::vector<Vector3d> corners;
    if (!box.min.allFinite() || !box.max.allFinite()) return corners;
    for (int k = 0; k < 8; ++k)
        corners.push_back(pose * Vector3d(k & 1 ? box.max.x() : box.min.x(), k & 2 ? box.max.y() : box.min.y(),
                                          k & 4 ? box.max.z() : box.min.z()));
    return corners;
}

} // namespace

RayPictures::RayPictures(const Scene& scene, const Settings& settings, const std::vector<std::uint8_t>& shown)
    : scene_(scene), world_(settings), geometries_(scene.geometries), models_(scene.geometries.size())
{
    for (std::uint32_t body = 0; body < scene.size(); ++body) {
        if (!shown[body]) continue;
        ModelId& model = models_[index(scene.geometry[body])];
        if (!model) model = add_model(world_.models(), scene.geometries, index(scene.geometry[body]));
        const BodyId id = world_.bodies().add({.model = model, .pose = scene.poses[body]});
        rows_.push_back({body, id});
        colours_.resize(std::max<std::size_t>(colours_.size(), index(id) + 1));
        colours_[index(id)] = surface_colour(body);
        unbounded_ |= corners_of(scene.geometries[index(scene.geometry[body])], scene.poses[body]).empty();
    }
}

void RayPictures::move(const Scene& scene)
{
    for (const std::uint32_t g : scene.geometries.deforming())
        if (models_[g] && geometries_.share(g) != scene.geometries.share(g))
            renew_model(world_.models(), models_[g], scene.geometries, g);
    geometries_ = scene.geometries;
    for (const Row& row : rows_) world_.bodies().set_pose(row.id, scene.poses[row.body]);
}

void RayPictures::frame(Framing& framing) const
{
    for (const Row& row : rows_)
        for (const Vector3d& corner :
             corners_of(scene_.geometries[index(scene_.geometry[row.body])], scene_.poses[row.body]))
            framing.add(corner, 0);
}

/// The distance from the eye to the farthest point of all bounded bodies, and a multiple of it if there are others.
double RayPictures::view_length(const Vector3d& eye) const
{
    double length = 0;
    for (const Row& row : rows_)
        for (const Vector3d& corner :
             corners_of(scene_.geometries[index(scene_.geometry[row.body])], scene_.poses[row.body]))
            length = std::max(length, (corner - eye).norm());
    if (unbounded_) length = std::max(20 * length, far_away);
    return 1.001 * length;
}

void RayPictures::cast(const std::vector<Segment>& segments, std::vector<CastHit>& hits)
{
    hits.resize(segments.size());
    const Clock::time_point from = Clock::now();
    world_.space().cast(segments, {}, hits);
    ms_ += milliseconds_since(from), rays_ += segments.size();
    hits_ += std::uint64_t(std::ranges::count_if(hits, [](const CastHit& hit) { return bool(hit.body); }));
}

Image RayPictures::draw(const Camera& camera, int width, int height)
{
    Image image = blank(width, height);
    if (rows_.empty()) return image;
    const Eigen::Isometry3d to_world = view_of(camera).inverse();
    const double length = view_length(camera.eye);
    const double pixel =
        2 * std::tan(0.5 * camera.view_angle) / (samples_per_side * height); // size of a sample at distance 1
    std::vector<Segment> segments;
    std::vector<CastHit> hits;
    for (int top = 0; top < height; top += band) {
        const int rows = samples_per_side * std::min(band, height - top), columns = samples_per_side * width;
        segments.clear();
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < columns; ++x) {
                const Vector3d direction((x + 0.5 - 0.5 * columns) * pixel,
                                         (0.5 * samples_per_side * height - (samples_per_side * top + y + 0.5)) * pixel,
                                         -1);
                segments.push_back({camera.eye, camera.eye + to_world.linear() * direction.normalized() * length});
            }
        cast(segments, hits);
        for (int y = 0; y < rows / samples_per_side; ++y)
            for (int x = 0; x < width; ++x) {
                std::array<Colour, samples_per_pixel> samples;
                for (int k = 0; k < int(samples_per_pixel); ++k) {
                    const std::size_t i =
                        std::size_t(samples_per_side * y + k / samples_per_side) * std::size_t(columns) +
                        std::size_t(samples_per_side * x + k % samples_per_side);
                    const double facing = hits[i].normal.dot((segments[i].to - segments[i].from) / length);
                    samples[std::size_t(k)] =
                        hits[i].body ? lit(colours_[index(hits[i].body)], light_of(facing)) : Colour{255, 255, 255};
                }
                image.set(x, top + y, mean(samples));
            }
    }
    return image;
}

} // namespace oncollide::tools
