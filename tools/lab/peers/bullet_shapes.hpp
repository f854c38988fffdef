// Geometries as Bullet's shapes.
#pragma once
#include "peers/bullet_world.hpp"

#include <map>

namespace oncollide::tools::bullet {

class BulletTerrain;

/// Makes each shape once, and keeps it.
class BulletShapes {
public:
    /// @param hulls  moving meshes are their convex hulls, else GImpact shapes
    explicit BulletShapes(bool hulls);
    ~BulletShapes();
    BulletShapes(const BulletShapes&) = delete;
    BulletShapes& operator=(const BulletShapes&) = delete;

    struct Shape {
        btCollisionShape* shape;
        Eigen::Vector3d origin; ///< of Bullet's shape in the geometry's frame
    };
    /// Shapes become primitives of Bullet, static meshes become trees of triangles, terrains become height fields.
    Shape of(const Geometry& geometry, bool is_static);
    /// The terrain's lowest and highest height must stay.
    void set_heights(const Geometry& terrain, const TerrainRectangle& where, std::span<const double> heights);

private:
    std::unique_ptr<btCollisionShape> make(const Geometry& geometry, bool is_static);

    const bool hulls_;
    std::map<const Geometry*, std::unique_ptr<BulletMesh>> meshes_;
    std::map<const Geometry*, std::unique_ptr<BulletTerrain>> terrains_;
    std::map<std::pair<const Geometry*, bool>, std::unique_ptr<btCollisionShape>> shapes_;
};

} // namespace oncollide::tools::bullet
