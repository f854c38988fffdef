#include "geometry_of_shape.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>

#include <assimp/scene.h>
#include <dart/common/Console.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/CapsuleShape.hpp>
#include <dart/dynamics/ConeShape.hpp>
#include <dart/dynamics/CylinderShape.hpp>
#include <dart/dynamics/EllipsoidShape.hpp>
#include <dart/dynamics/HeightmapShape.hpp>
#include <dart/dynamics/MeshShape.hpp>
#include <dart/dynamics/MultiSphereConvexHullShape.hpp>
#include <dart/dynamics/PlaneShape.hpp>
#include <dart/dynamics/PyramidShape.hpp>
#include <dart/dynamics/SoftMeshShape.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <dart/dynamics/VoxelGridShape.hpp>

namespace dart::collision::oncollide_client {

namespace {

using dynamics::Shape;
using oncollide::GeometryData;

template <class T>
const T* as(const Shape& shape)
{
    return shape.is<T>() ? static_cast<const T*>(&shape) : nullptr;
}

/// DART's meshes have no common vertices where normals differ: vertices at one position become one here.
class WeldedMesh {
public:
    void add(const aiMesh& mesh, const Eigen::Vector3d& scale)
    {
        for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
            const aiFace& face = mesh.mFaces[f];
            const auto at = [&](unsigned i) { return vertex(mesh.mVertices[face.mIndices[i]], scale); };
            for (unsigned i = 2; i < face.mNumIndices; ++i) triangles_.push_back({at(0), at(i - 1), at(i)});
        }
    }
    oncollide::Mesh made(const std::string& name)
    {
        return oncollide::make_mesh(name, std::move(vertices_), std::move(triangles_));
    }

private:
    std::uint32_t vertex(const aiVector3D& v, const Eigen::Vector3d& scale)
    {
        const auto [at, is_new] = numbers_.try_emplace({v.x, v.y, v.z}, static_cast<std::uint32_t>(vertices_.size()));
        if (is_new) vertices_.push_back(scale.cwiseProduct(Eigen::Vector3d(v.x, v.y, v.z)));
        return at->second;
    }

    std::map<std::array<float, 3>, std::uint32_t> numbers_;
    std::vector<Eigen::Vector3d> vertices_;
    std::vector<oncollide::Triangle> triangles_;
};

oncollide::Mesh welded_mesh_of(const dynamics::MeshShape& shape, const std::string& name)
{
    WeldedMesh welded;
    const aiScene* scene = shape.getMesh();
    for (unsigned i = 0; scene && i < scene->mNumMeshes; ++i) welded.add(*scene->mMeshes[i], shape.getScale());
    return welded.made(name);
}

/// Encloses the hull of the spheres, by at most 0.5 % of the largest radius.
oncollide::ConvexHull hull_of(const dynamics::MultiSphereConvexHullShape& shape)
{
    oncollide::ConvexHull hull;
    for (const auto& [radius, centre] : shape.getSpheres())
        for (const Eigen::Vector3d& v : oncollide::bounding_mesh_of(oncollide::Sphere{radius}).mesh.vertices)
            hull.points.push_back(centre + v);
    return hull;
}

oncollide::ConvexHull hull_of(const dynamics::PyramidShape& shape)
{
    const double x = shape.getBaseWidth() / 2, y = shape.getBaseDepth() / 2, z = shape.getHeight() / 2;
    return {{{x, y, -z}, {-x, y, -z}, {-x, -y, -z}, {x, -y, -z}, {0, 0, z}}};
}

/// Closes a terrain with walls and a floor at z = 0, or lower: at least 1 % of its width below its surface.
oncollide::Mesh solid_of(const oncollide::Terrain& terrain, const std::string& name)
{
    oncollide::Mesh top = oncollide::mesh_of(terrain);
    const std::uint32_t columns = terrain.columns(), rows = terrain.rows();
    const Eigen::Vector3d size = top.bounds.max - top.bounds.min;
    const double floor = std::min(0.0, top.bounds.min.z() - 0.01 * size.head<2>().maxCoeff());
    const auto first = static_cast<std::uint32_t>(top.vertices.size());
    std::vector<std::pair<std::uint32_t, std::uint32_t>> border; // column and row, counter-clockwise
    for (std::uint32_t c = 0; c + 1 < columns; ++c) border.emplace_back(c, 0);
    for (std::uint32_t r = 0; r + 1 < rows; ++r) border.emplace_back(columns - 1, r);
    for (std::uint32_t c = columns - 1; c > 0; --c) border.emplace_back(c, rows - 1);
    for (std::uint32_t r = rows - 1; r > 0; --r) border.emplace_back(0, r);
    const auto n = static_cast<std::uint32_t>(border.size());
    for (const bool above : {true, false}) // the border, then its shadow on the floor, then the floor's centre
        for (const auto& [c, r] : border) {
            const Eigen::Vector3d p = terrain.point(c, r);
            top.vertices.emplace_back(p.x(), p.y(), above ? p.z() : floor);
        }
    const Eigen::Vector3d centre = top.bounds.centre();
    top.vertices.emplace_back(centre.x(), centre.y(), floor);
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t a = first + i, b = first + (i + 1) % n;
        top.triangles.push_back({a, a + n, b + n});
        top.triangles.push_back({a, b + n, b});
        top.triangles.push_back({b + n, a + n, first + 2 * n});
    }
    return oncollide::make_mesh(name, std::move(top.vertices), std::move(top.triangles));
}

/// DART's first row is the one of greatest y.
template <class S>
GeometryData terrain_of(const dynamics::HeightmapShape<S>& shape, bool solid, const std::string& name)
{
    const auto& heights = shape.getHeightField();
    const Eigen::Vector3d scale = shape.getScale().template cast<double>();
    oncollide::TerrainGrid grid;
    grid.columns = static_cast<std::uint32_t>(heights.cols()), grid.rows = static_cast<std::uint32_t>(heights.rows());
    grid.spacing = scale.head<2>();
    grid.origin = {-0.5 * (grid.columns - 1.0) * scale.x(), -0.5 * (grid.rows - 1.0) * scale.y(), 0};
    std::vector<double> z;
    for (Eigen::Index r = heights.rows(); r-- > 0;)
        for (Eigen::Index c = 0; c < heights.cols(); ++c) z.push_back(scale.z() * heights(r, c));
    oncollide::Terrain terrain = oncollide::make_terrain(name, grid, z);
    if (solid) return solid_of(terrain, name);
    return terrain;
}

bool has_occupied_cells(const octomap::OcTree& tree)
{
    return std::any_of(tree.begin_leafs(), tree.end_leafs(),
                       [&](const auto& leaf) { return tree.isNodeOccupied(leaf); });
}

/// Throws oncollide::Error for a shape without an extent, and the like; false for an unknown one. An empty map sets no
/// data.
bool convert(const Shape& shape, bool solid, const std::string& name, std::optional<GeometryData>& data,
             Eigen::Isometry3d& pose)
{
    using namespace dynamics;
    if (const auto* box = as<BoxShape>(shape))
        data = oncollide::Shape(oncollide::Box{box->getSize() / 2});
    else if (const auto* sphere = as<SphereShape>(shape))
        data = oncollide::Shape(oncollide::Sphere{sphere->getRadius()});
    else if (const auto* ellipsoid = as<EllipsoidShape>(shape)) {
        const Eigen::Vector3d r = ellipsoid->getDiameters() / 2;
        const bool round = r.x() == r.y() && r.y() == r.z();
        data = round ? oncollide::Shape(oncollide::Sphere{r.x()}) : oncollide::Shape(oncollide::Ellipsoid{r});
    } else if (const auto* capsule = as<CapsuleShape>(shape))
        data = oncollide::Shape(oncollide::Capsule{capsule->getRadius(), capsule->getHeight()});
    else if (const auto* cylinder = as<CylinderShape>(shape))
        data = oncollide::Shape(oncollide::Cylinder{cylinder->getRadius(), cylinder->getHeight()});
    else if (const auto* cone = as<ConeShape>(shape))
        data = oncollide::Shape(oncollide::Cone{cone->getRadius(), cone->getHeight()});
    else if (const auto* pyramid = as<PyramidShape>(shape))
        data = oncollide::Shape(hull_of(*pyramid));
    else if (const auto* spheres = as<MultiSphereConvexHullShape>(shape))
        data = oncollide::Shape(hull_of(*spheres));
    else if (const auto* plane = as<PlaneShape>(shape)) {
        data = oncollide::Shape(oncollide::HalfSpace{});
        pose.linear() = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), plane->getNormal()).matrix();
        pose.translation() = plane->getOffset() * plane->getNormal();
    } else if (const auto* mesh = as<MeshShape>(shape)) // an arrow, too
        data = welded_mesh_of(*mesh, name);
    else if (const auto* soft = as<SoftMeshShape>(shape))
        data = oncollide_client::mesh_of(*soft);
    else if (const auto* heights = as<HeightmapShaped>(shape))
        data = terrain_of(*heights, solid, name);
    else if (const auto* floats = as<HeightmapShapef>(shape))
        data = terrain_of(*floats, solid, name);
    else if (const auto* voxels = as<VoxelGridShape>(shape)) {
        if (has_occupied_cells(*voxels->getOctree())) data = oncollide::make_occupancy_map(*voxels->getOctree());
    } else
        return false;
    return true;
}

} // namespace

PlacedGeometry geometry_of(const Shape& shape, bool solid_heightmaps)
{
    const std::string name = shape.getType() + " " + std::to_string(shape.getID());
    std::optional<GeometryData> data;
    PlacedGeometry placed;
    try {
        if (convert(shape, solid_heightmaps, name, data, placed.pose)) {
            if (data)
                placed.geometry =
                    std::make_shared<oncollide::Geometry>(oncollide::Geometry{name, *std::move(data), {}});
            return placed;
        }
        dtwarn << "[OncollideCollisionDetector] '" << shape.getType() << "' has no model in oncollide; it will have no "
               << "contacts.\n";
    } catch (const oncollide::Error& error) {
        dtwarn << "[OncollideCollisionDetector] " << error.what() << "; it will have no contacts.\n";
    }
    return placed;
}

oncollide::Mesh mesh_of(const dynamics::SoftMeshShape& shape)
{
    WeldedMesh welded;
    welded.add(*shape.getAssimpMesh(), Eigen::Vector3d::Ones());
    return welded.made(shape.getType() + " " + std::to_string(shape.getID()));
}

int face_near(const dynamics::SoftMeshShape& shape, const Eigen::Vector3d& point)
{
    const aiMesh& mesh = *shape.getAssimpMesh();
    int nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (unsigned f = 0; f < mesh.mNumFaces; ++f)
        for (unsigned i = 0; i < mesh.mFaces[f].mNumIndices; ++i) {
            const aiVector3D& v = mesh.mVertices[mesh.mFaces[f].mIndices[i]];
            const double apart = (Eigen::Vector3d(v.x, v.y, v.z) - point).squaredNorm();
            if (apart < least) least = apart, nearest = static_cast<int>(f);
        }
    return nearest;
}

} // namespace dart::collision::oncollide_client
