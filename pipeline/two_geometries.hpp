#pragma once
#include <concepts>
#include <cstdint>
#include <limits>
#include <memory>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/scenes/geometry.hpp>

namespace oncollide {

/// A geometry of any kind, for the calls below. A mesh is not copied and must outlive the call.
class GeometryArgument {
public:
    GeometryArgument(const Mesh& mesh) : mesh_(&mesh) {}
    template <std::convertible_to<std::shared_ptr<const Geometry>> Pointer> // as load_geometry() returns it
    GeometryArgument(const Pointer& geometry)
        : geometry_(geometry), mesh_(geometry_ ? std::get_if<Mesh>(&geometry_->data) : nullptr)
    {
    }
    template <class Data> // a Shape (Sphere, Box, ...), an OccupancyMap, a Terrain
    requires(std::constructible_from<GeometryData, Data> && !std::same_as<Data, Mesh>)
        GeometryArgument(const Data& data)
        : GeometryArgument(std::make_shared<const Geometry>(Geometry{{}, data, {}}))
    {
    }
    const Mesh* mesh() const { return mesh_; } ///< null: another kind, see geometry()
    const std::shared_ptr<const Geometry>& geometry() const { return geometry_; }

private:
    std::shared_ptr<const Geometry> geometry_;
    const Mesh* mesh_ = nullptr;
};

// --- Two geometries at two poses, in one line. Poses are rigid: body frame to world, metres.
// Each call builds its trees (5 ns per triangle, 60 ns per traversed triangle); a World keeps them.
// Throw Error{bad_data} for poses that are not rigid, and for a geometry that Models::add() would refuse.

/// Exact: the verdict is separate or colliding, or, where a shape is round, within for a gap that rounding hides;
/// touching counts as colliding.
ONCOLLIDE_API Finding collide(const GeometryArgument& a, const Eigen::Isometry3d& pose_a, const GeometryArgument& b,
                              const Eigen::Isometry3d& pose_b);

/// As Pairs::distance().
ONCOLLIDE_API Distance distance(const GeometryArgument& a, const Eigen::Isometry3d& pose_a, const GeometryArgument& b,
                                const Eigen::Isometry3d& pose_b, const DistanceOptions& options = {});

/// As Pairs::contacts().
ONCOLLIDE_API std::vector<Contact> contacts(const GeometryArgument& a, const Eigen::Isometry3d& pose_a,
                                            const GeometryArgument& b, const Eigen::Isometry3d& pose_b);

/// As Pairs::penetration().
ONCOLLIDE_API Penetration penetration(const GeometryArgument& a, const Eigen::Isometry3d& pose_a,
                                      const GeometryArgument& b, const Eigen::Isometry3d& pose_b);

// --- One mesh and itself.

/// As Models::self_contacts(), on one thread. Throws Error{bad_data} for a mesh that Models::add() would refuse.
ONCOLLIDE_API std::vector<PairOf<std::uint32_t>>
self_contacts(const Mesh& mesh, std::size_t most = std::numeric_limits<std::size_t>::max());

/// As Models::near_features(), on one thread.
ONCOLLIDE_API std::vector<NearFeatures> near_features(const Mesh& mesh, double dhat,
                                                      const SelfNearOptions& options = {});

} // namespace oncollide
