#include <oncollide/scenes/scene.hpp>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

namespace {

[[noreturn]] void fail(std::string_view kind, const std::string& name, const std::string& what)
{
    throw Error(ErrorKind::bad_data, fmt::format("{} '{}': {}", kind, name, what));
}

Aabb bounds_of(const Mesh& mesh)
{
    return mesh.bounds;
}

Aabb bounds_of(const OccupancyMap& map)
{
    return map.bounds;
}

} // namespace

Aabb bounds_of(const GeometryData& geometry)
{
    return std::visit([](const auto& data) { return bounds_of(data); }, geometry);
}
Aabb bounds_of(const Geometry& geometry)
{
    return bounds_of(geometry.data);
}

std::string why_not_rigid(const Eigen::Isometry3d& pose)
{
    constexpr double tolerance = 1e-6;
    if (!pose.matrix().allFinite()) return "the pose is not finite";
    if (pose.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1)) return "the pose's last row is not (0, 0, 0, 1)";
    const Eigen::Matrix3d r = pose.linear();
    const double off = (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    if (!(off <= tolerance))
        return fmt::format("the pose is not rigid: R^T R is off the identity by {:.3g}, at most {} is allowed", off,
                           tolerance);
    if (r.determinant() < 0) return "the pose is not rigid: it mirrors (the determinant of R is negative)";
    return {};
}

bool NameIndex::add(std::string_view name)
{
    return indices_.emplace(name, static_cast<std::uint32_t>(indices_.size())).second;
}

std::optional<std::uint32_t> NameIndex::find(std::string_view name) const
{
    const auto found = indices_.find(name);
    return found == indices_.end() ? std::nullopt : std::optional(found->second);
}

GeometryId Scene::add(std::string geometry_name, GeometryData data, std::string recipe)
{
    if (const Shape* shape = std::get_if<Shape>(&data)) check_shape(geometry_name, *shape);
    if (!geometry_index_.add(geometry_name)) fail("geometry", geometry_name, "the scene has another one of this name");
    geometries.push_back({std::move(geometry_name), std::move(data), std::move(recipe)});
    return GeometryId{static_cast<std::uint32_t>(geometries.size() - 1)};
}

BodyId Scene::add_body(BodyInit body)
{
    if (index(body.geometry) >= geometries.size())
        fail("body", body.name,
             fmt::format("uses geometry number {}, but the scene has {}", index(body.geometry), geometries.size()));
    if (const std::string why = why_not_rigid(body.pose); !why.empty()) fail("body", body.name, why);
    if (body.is_static && !std::holds_alternative<Still>(body.motion))
        fail("body", body.name, "is static, so it cannot have a motion");
    check_motion(fmt::format("body '{}'", body.name), body.motion);
    if (!body_index_.add(body.name)) fail("body", body.name, "the scene has another one of this name");

    names.push_back(std::move(body.name));
    geometry.push_back(body.geometry);
    poses.push_back(body.pose);
    start_poses.push_back(body.pose);
    motions.push_back(std::move(body.motion));
    is_static.push_back(body.is_static);
    layers.push_back(body.layer);
    masks.push_back(body.mask);
    return BodyId{static_cast<std::uint32_t>(names.size() - 1)};
}

std::optional<BodyId> Scene::find(std::string_view body) const
{
    const std::optional<std::uint32_t> found = body_index_.find(body);
    return found ? std::optional(BodyId{*found}) : std::nullopt;
}

std::optional<GeometryId> Scene::find_geometry(std::string_view geometry_name) const
{
    const std::optional<std::uint32_t> found = geometry_index_.find(geometry_name);
    return found ? std::optional(GeometryId{*found}) : std::nullopt;
}

void Mover::move(Scene& scene, int frame)
{
    if (!ready_) {
        for (std::uint32_t i = 0; i < scene.size(); ++i)
            if (!std::holds_alternative<Still>(scene.motions[i])) moving_.push_back(i);
    }
    const bool from_start = !ready_ || frame < last_frame_;
    const int first = from_start ? 1 : last_frame_ + 1;
    for (const std::uint32_t i : moving_) {
        Eigen::Isometry3d& pose = scene.poses[i];
        if (const Jitter* jitter = std::get_if<Jitter>(&scene.motions[i])) {
            if (from_start) pose = scene.start_poses[i];
            Eigen::Vector3d position = pose.translation();
            for (int f = first; f <= frame; ++f) jitter_step(*jitter, static_cast<std::uint64_t>(f), position);
            pose.translation() = position;
        } else {
            pose = pose_at(scene.motions[i], scene.start_poses[i], frame);
        }
    }
    last_frame_ = frame;
    ready_ = true;
}

} // namespace oncollide
