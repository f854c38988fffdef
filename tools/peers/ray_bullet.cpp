// Bullet's rayTest against a world of one static mesh.
#include "peers/ray_peer.hpp"

#include <btBulletCollisionCommon.h>

namespace oncollide::tools {
namespace {

class BulletRayPeer final : public RayPeer {
public:
    explicit BulletRayPeer(const Mesh& mesh)
        : dispatcher_(&configuration_), world_(&dispatcher_, &broad_, &configuration_)
    {
        for (const Eigen::Vector3d& v : mesh.vertices)
            for (int axis = 0; axis < 3; ++axis) vertices_.push_back(btScalar(v[axis]));
        for (const Triangle& t : mesh.triangles) indices_.insert(indices_.end(), t.begin(), t.end());
        arrays_ = std::make_unique<btTriangleIndexVertexArray>(int(mesh.triangles.size()), indices_.data(),
                                                               int(3 * sizeof(int)), int(mesh.vertices.size()),
                                                               vertices_.data(), int(3 * sizeof(btScalar)));
        shape_ = std::make_unique<btBvhTriangleMeshShape>(arrays_.get(), true);
        body_.setCollisionShape(shape_.get());
        world_.addCollisionObject(&body_);
    }
    ~BulletRayPeer() override { world_.removeCollisionObject(&body_); }
    BulletRayPeer(const BulletRayPeer&) = delete;
    BulletRayPeer& operator=(const BulletRayPeer&) = delete;

    void trace(std::span<const Segment> segments, std::span<std::uint8_t> hit) override
    {
        const auto point = [](const Eigen::Vector3d& p) {
            return btVector3(btScalar(p.x()), btScalar(p.y()), btScalar(p.z()));
        };
        for (std::size_t i = 0; i < segments.size(); ++i) {
            const btVector3 from = point(segments[i].from), to = point(segments[i].to);
            btCollisionWorld::ClosestRayResultCallback found(from, to);
            world_.rayTest(from, to, found);
            hit[i] = found.hasHit();
        }
    }

private:
    std::vector<btScalar> vertices_;
    std::vector<int> indices_;
    std::unique_ptr<btTriangleIndexVertexArray> arrays_;
    std::unique_ptr<btBvhTriangleMeshShape> shape_;
    btCollisionObject body_;
    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_;
    btDbvtBroadphase broad_;
    btCollisionWorld world_;
};

} // namespace

void add_ray_bullet(std::vector<RayContender>& all)
{
    all.push_back({.name = "bullet",
                   .what = "Bullet rayTest, btBvhTriangleMeshShape, single precision; the closest hit",
                   .exact = false,
                   .make = [](const Mesh& mesh) { return std::make_unique<BulletRayPeer>(mesh); }});
}

} // namespace oncollide::tools
