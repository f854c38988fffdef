#include <oncollide/robots/distances/nearest_features.hpp>

#include <algorithm>
#include <array>

#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/shapes/convex.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

/// The feature of a convex part along a direction: a point, an edge along `along`, or a face.
struct Feature {
    int dimensions = 0;
    Vector3d along = Vector3d::Zero(); ///< unit, world frame
};

constexpr double parallel = 1e-7; // rad

Feature feature_of(const Convex& part, const Eigen::Isometry3d& pose, const Vector3d& out, double tilt)
{
    const Vector3d n = pose.linear().transpose() * out, u = n.unitOrthogonal(), v = n.cross(u);
    std::array<Vector3d, 4> ends;
    for (std::size_t k = 0; k < 4; ++k) {
        const double sign = k % 2 ? -tilt : tilt;
        ends[k] = part.support(n + sign * (k < 2 ? u : v));
    }
    // A curved part's support point moves by its radius of curvature times the tilt.
    const double same = 16 * tilt * part.extent;
    Vector3d longest = Vector3d::Zero();
    for (const Vector3d& p : ends)
        for (const Vector3d& q : ends)
            if ((p - q).squaredNorm() > longest.squaredNorm()) longest = p - q;
    if (longest.norm() <= same) return {};
    longest.normalize();
    double wide = 0;
    for (const Vector3d& p : ends) wide = std::max(wide, (p - ends[0]).cross(longest).norm());
    return {wide > same ? 2 : 1, pose.linear() * longest};
}

/// The feature of the part of a body that has its nearest point.
Feature feature_of(const Model& model, const BodyPart& part, const Eigen::Isometry3d& pose, const Vector3d& out,
                   double tilt)
{
    const GeometryData& data = model.geometry().data;
    if (model.kind() == Kind::half_space) return {2, Vector3d::Zero()};
    if (model.is_bounded_shape()) return feature_of(model.convex(), pose, out, tilt);
    if (const Mesh* const mesh = std::get_if<Mesh>(&data)) {
        const Triangle& t = mesh->triangles[part.triangle];
        const std::array corners{mesh->vertices[t[0]], mesh->vertices[t[1]], mesh->vertices[t[2]]};
        return feature_of(convex_of(corners), pose, out, tilt);
    }
    return {2, Vector3d::Zero()}; // not known
}

} // namespace

bool have_one_nearest_pair(const PairTask& task, const Distance& found, const Vector3d& normal)
{
    const double size = task.pose_a->translation().norm() + task.pose_b->translation().norm() + found.point_a.norm() +
                        found.point_b.norm();
    const double tilt = std::max(parallel, 0x1p-48 * size / found.upper);
    if (!(tilt < 0x1p-10)) return false; // so near that rounding turns the normal
    const Feature a = feature_of(*task.a, found.a, *task.pose_a, normal, tilt);
    if (a.dimensions == 0) return true;
    const Feature b = feature_of(*task.b, found.b, *task.pose_b, -normal, tilt);
    if (b.dimensions == 0) return true;
    return a.dimensions == 1 && b.dimensions == 1 && a.along.cross(b.along).norm() > 16 * tilt;
}

} // namespace oncollide
