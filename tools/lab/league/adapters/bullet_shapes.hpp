// Bodies of the league as Bullet's shapes.
#pragma once
#include <memory>
#include <stdexcept>
#include <vector>

#include <BulletCollision/CollisionDispatch/btInternalEdgeUtility.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletCollisionCommon.h>

#include "common.hpp"

namespace league::bullet {

inline btVector3 vector_of(const double* p)
{
    return {btScalar(p[0]), btScalar(p[1]), btScalar(p[2])};
}

inline void copy(const btVector3& from, double* to)
{
    for (int k = 0; k < 3; ++k) to[k] = double(from[k]);
}

inline btTransform pose_of(const league_body& body)
{
    const btVector3 x = vector_of(body.rotation), y = vector_of(body.rotation + 3), z = vector_of(body.rotation + 6);
    const btMatrix3x3 rotation(x.x(), x.y(), x.z(), y.x(), y.y(), y.z(), z.x(), z.y(), z.z());
    return btTransform(rotation, vector_of(body.position));
}

/// Bullet has none of its own, but takes a convex shape from its user.
class Ellipsoid final : public btConvexInternalShape {
public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    explicit Ellipsoid(const btVector3& half_axes)
    {
        m_shapeType = CUSTOM_CONVEX_SHAPE_TYPE;
        m_implicitShapeDimensions = half_axes;
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
    void calculateLocalInertia(btScalar, btVector3& inertia) const override { inertia.setZero(); }
    const char* getName() const override { return "Ellipsoid"; }
};

inline std::unique_ptr<btConvexShape> make_convex(const league_body& body)
{
    const auto radius = btScalar(body.size[0]), half = btScalar(body.size[1]);
    switch (body.kind) {
    case LEAGUE_SPHERE:
        return std::make_unique<btSphereShape>(radius);
    case LEAGUE_CAPSULE:
        return std::make_unique<btCapsuleShapeZ>(radius, 2 * half);
    case LEAGUE_BOX:
        return std::make_unique<btBoxShape>(vector_of(body.size));
    case LEAGUE_CYLINDER:
        return std::make_unique<btCylinderShapeZ>(btVector3(radius, radius, half));
    case LEAGUE_CONE:
        return std::make_unique<btConeShapeZ>(radius, 2 * half);
    case LEAGUE_ELLIPSOID:
        return std::make_unique<Ellipsoid>(vector_of(body.size));
    default: {
        auto hull = std::make_unique<btConvexHullShape>();
        for (std::size_t i = 0; i < body.vertex_count; ++i) hull->addPoint(vector_of(body.vertices + 3 * i), false);
        hull->recalcLocalAabb();
        return hull;
    }
    }
}

/// Bullet's shapes point to one another and to the triangles.
class Shape {
public:
    /// @param deforming  a mesh in GImpact's form, which may move and meet other meshes
    Shape(const league_body& body, bool deforming)
    {
        if (league::is_convex(body.kind)) {
            auto made = make_convex(body);
            // Margins of spheres and capsules are their radii. All others make the body larger, or round its corners.
            if (body.kind != LEAGUE_SPHERE && body.kind != LEAGUE_CAPSULE) made->setMargin(0);
            shape_ = std::move(made);
        } else if (body.kind == LEAGUE_HALF_SPACE) {
            shape_ = std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), btScalar(0));
            shape_->setMargin(0);
        } else if (body.kind == LEAGUE_CELLS) {
            make_cells(body);
        } else {
            make_mesh(body, deforming);
        }
    }

    btCollisionShape* get() const { return shape_.get(); }
    /// Finds the faces of boxes and hulls, which contacts are clipped to, and the inner edges of a mesh.
    void prepare_contacts()
    {
        for (btCollisionShape* shape : {shape_.get(), static_cast<btCollisionShape*>(cell_.get())})
            if (shape && shape->isPolyhedral())
                static_cast<btPolyhedralConvexShape*>(shape)->initializePolyhedralFeatures();
        if (shape_->getShapeType() == TRIANGLE_MESH_SHAPE_PROXYTYPE)
            btGenerateInternalEdgeInfo(static_cast<btBvhTriangleMeshShape*>(shape_.get()), &edges_);
    }

    const btConvexShape* convex() const { return static_cast<const btConvexShape*>(shape_.get()); }

private:
    void make_cells(const league_body& body)
    {
        const auto half = btScalar(body.size[0] / 2);
        cell_ = std::make_unique<btBoxShape>(btVector3(half, half, half));
        cell_->setMargin(0);
        auto cells = std::make_unique<btCompoundShape>(true, int(body.vertex_count));
        for (std::size_t i = 0; i < body.vertex_count; ++i)
            cells->addChildShape(btTransform(btMatrix3x3::getIdentity(), vector_of(body.vertices + 3 * i)),
                                 cell_.get());
        cells->setMargin(0);
        shape_ = std::move(cells);
    }

    void make_mesh(const league_body& body, bool deforming)
    {
        // btQuantizedBvh has 21 bits for a triangle.
        if (body.triangle_count == 0 || body.triangle_count >= std::size_t{1} << 21)
            throw std::length_error("too many triangles");
        vertices_.assign(body.vertices, body.vertices + 3 * body.vertex_count);
        indices_.assign(body.triangles, body.triangles + 3 * body.triangle_count);
        arrays_ = std::make_unique<btTriangleIndexVertexArray>(int(body.triangle_count), indices_.data(),
                                                               int(3 * sizeof(int)), int(body.vertex_count),
                                                               vertices_.data(), int(3 * sizeof(btScalar)));
        if (deforming) {
            auto made = std::make_unique<btGImpactMeshShape>(arrays_.get());
            made->setMargin(0);
            made->updateBound();
            shape_ = std::move(made);
        } else {
            shape_ = std::make_unique<btBvhTriangleMeshShape>(arrays_.get(), true);
            shape_->setMargin(0);
        }
    }

    std::vector<btScalar> vertices_;
    std::vector<int> indices_;
    std::unique_ptr<btTriangleIndexVertexArray> arrays_;
    std::unique_ptr<btBoxShape> cell_;
    btTriangleInfoMap edges_;
    std::unique_ptr<btCollisionShape> shape_; ///< declared last: destroyed before the data that it points to
};

} // namespace league::bullet
