// Bullet's rayTest against a world of one static mesh.
#include "peers/common/bullet_mesh.hpp"
#include "peers/rays/ray_peer.hpp"

#include <btBulletCollisionCommon.h>

namespace oncollide::tools {
namespace {

class BulletRayPeer final : public RayPeer {
public:
    explicit BulletRayPeer(const Mesh& mesh)
        : mesh_(mesh), shape_(mesh_.arrays(), true), dispatcher_(&configuration_),
          world_(&dispatcher_, &broad_, &configuration_)
    {
        body_.setCollisionShape(&shape_);
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
    BulletMesh mesh_;
    btBvhTriangleMeshShape shape_;
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
                   .promise = Promise::approximate,
                   .most = std::size_t{1} << 21, // bits of a triangle's index in btQuantizedBvh; it crashes with more
                   .make = [](const Mesh& mesh) { return std::make_unique<BulletRayPeer>(mesh); }});
}

} // namespace oncollide::tools
