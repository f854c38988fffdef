#include "peers/bullet_shapes.hpp"

#include <algorithm>

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

namespace oncollide::tools::bullet {
namespace {

/// Bullet adds it around hulls, cones and ellipsoids; its default of 40 mm is as large as such a body.
constexpr btScalar around = 1e-3F;

/// Bullet has none of its own.
class EllipsoidShape final : public btConvexInternalShape {
public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    explicit EllipsoidShape(const Eigen::Vector3d& semi_axes)
    {
        m_shapeType = CUSTOM_CONVEX_SHAPE_TYPE;
        m_implicitShapeDimensions = vector_of(semi_axes);
    }
    btVector3 localGetSupportingVertexWithoutMargin(const btVector3& d) const override
    {
        const btVector3 scaled = d * m_implicitShapeDimensions;
        const btScalar length = scaled.length();
        return length > 0 ? scaled * m_implicitShapeDimensions / length
                          : btVector3(m_implicitShapeDimensions.x(), 0, 0);
    }
    void batchedUnitVectorGetSupportingVertexWithoutMargin(const btVector3* directions, btVector3* points,
                                                           int count) const override
    {
        for (int k = 0; k < count; ++k) points[k] = localGetSupportingVertexWithoutMargin(directions[k]);
    }
    void calculateLocalInertia(btScalar mass, btVector3& inertia) const override
    {
        const btVector3 squares = m_implicitShapeDimensions * m_implicitShapeDimensions;
        inertia = mass / 5 * btVector3(squares.y() + squares.z(), squares.z() + squares.x(), squares.x() + squares.y());
    }
    const char* getName() const override { return "Ellipsoid"; }
};

struct ShapeMaker {
    std::unique_ptr<btConvexShape> operator()(const Sphere& s) const
    {
        return std::make_unique<btSphereShape>(btScalar(s.radius));
    }
    std::unique_ptr<btConvexShape> operator()(const Box& s) const
    {
        return std::make_unique<btBoxShape>(vector_of(s.half));
    }
    std::unique_ptr<btConvexShape> operator()(const Capsule& s) const
    {
        return std::make_unique<btCapsuleShapeZ>(btScalar(s.radius), btScalar(s.length));
    }
    std::unique_ptr<btConvexShape> operator()(const Cylinder& s) const
    {
        return std::make_unique<btCylinderShapeZ>(vector_of({s.radius, s.radius, s.length / 2}));
    }
    std::unique_ptr<btConvexShape> operator()(const Cone& s) const
    {
        auto shape = std::make_unique<btConeShapeZ>(btScalar(s.radius), btScalar(s.length));
        shape->setMargin(around);
        return shape;
    }
    std::unique_ptr<btConvexShape> operator()(const Ellipsoid& s) const
    {
        auto shape = std::make_unique<EllipsoidShape>(s.semi_axes);
        shape->setMargin(around);
        return shape;
    }
    std::unique_ptr<btConvexShape> operator()(const ConvexHull& s) const
    {
        auto shape = std::make_unique<btConvexHullShape>();
        for (const Eigen::Vector3d& p : s.points) shape->addPoint(vector_of(p), false);
        shape->setMargin(around), shape->recalcLocalAabb();
        return shape;
    }
    std::unique_ptr<btConvexShape> operator()(const HalfSpace&) const
    {
        throw Error(ErrorKind::usage, "bench contacts: a half-space takes no part");
    }
};

std::unique_ptr<btConvexShape> hull_of(const Mesh& mesh)
{
    ConvexHull all{mesh.vertices};
    const Mesh surface = bounding_mesh_of(oncollide::Shape(std::move(all))).mesh; // its corners alone
    return ShapeMaker{}(ConvexHull{surface.vertices});
}

} // namespace

/// A terrain with one diagonal; Bullet's origin is in the middle of the grid and of the heights.
class BulletTerrain {
public:
    explicit BulletTerrain(const Terrain& terrain)
    {
        double low = terrain.point(0, 0).z(), high = low;
        for (std::uint32_t r = 0; r < terrain.rows(); ++r)
            for (std::uint32_t c = 0; c < terrain.columns(); ++c) {
                const double z = terrain.point(c, r).z();
                low = std::min(low, z), high = std::max(high, z), heights_.push_back(float(z));
            }
        const bool rising = terrain.diagonal(0, 0) == CellDiagonal::rising;
        shape = std::make_unique<btHeightfieldTerrainShape>(int(terrain.columns()), int(terrain.rows()),
                                                            heights_.data(), btScalar(low), btScalar(high), 2, rising);
        shape->setLocalScaling(vector_of({terrain.spacing().x(), terrain.spacing().y(), 1}));
        middle = 0.5 * (terrain.point(0, 0) + terrain.point(terrain.columns() - 1, terrain.rows() - 1));
        middle.z() = 0.5 * (low + high);
    }

    /// Bullet reads them where they are.
    void set_heights(const Terrain& terrain, const TerrainRectangle& where, std::span<const double> heights)
    {
        for (std::size_t row = 0; row < where.rows; ++row)
            for (std::size_t column = 0; column < where.columns; ++column)
                heights_[(where.row + row) * terrain.columns() + where.column + column] =
                    float(terrain.origin().z() + heights[row * where.columns + column]);
    }

private:
    std::vector<float> heights_;

public:
    std::unique_ptr<btHeightfieldTerrainShape> shape; ///< declared last: destroyed before the data it points to
    Eigen::Vector3d middle;
};

BulletShapes::BulletShapes(bool hulls) : hulls_(hulls) {}
BulletShapes::~BulletShapes() = default;

BulletShapes::Shape BulletShapes::of(const Geometry& geometry, bool is_static)
{
    if (const auto* terrain = std::get_if<Terrain>(&geometry.data)) {
        auto& made = terrains_[&geometry];
        if (!made) made = std::make_unique<BulletTerrain>(*terrain);
        return {made->shape.get(), made->middle};
    }
    auto& shape = shapes_[{&geometry, is_static}];
    if (!shape) shape = make(geometry, is_static);
    return {shape.get(), Eigen::Vector3d::Zero()};
}

void BulletShapes::set_heights(const Geometry& terrain, const TerrainRectangle& where, std::span<const double> heights)
{
    terrains_.at(&terrain)->set_heights(std::get<Terrain>(terrain.data), where, heights);
}

std::unique_ptr<btCollisionShape> BulletShapes::make(const Geometry& geometry, bool is_static)
{
    const auto* mesh = std::get_if<Mesh>(&geometry.data);
    if (!mesh) return std::visit(ShapeMaker{}, std::get<oncollide::Shape>(geometry.data));
    if (hulls_ && !is_static) return hull_of(*mesh);
    auto& data = meshes_[&geometry];
    if (!data) data = std::make_unique<BulletMesh>(*mesh);
    if (is_static) return std::make_unique<btBvhTriangleMeshShape>(data->arrays(), true);
    auto shape = std::make_unique<btGImpactMeshShape>(data->arrays());
    shape->updateBound();
    return shape;
}

} // namespace oncollide::tools::bullet
