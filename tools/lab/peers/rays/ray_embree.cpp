// Embree's tests of rays against a triangle mesh: occluded or not, and the closest hit.
#include "peers/rays/ray_peer.hpp"

#include <embree3/rtcore.h>

namespace oncollide::tools {
namespace {

class EmbreeRayPeer final : public RayPeer {
public:
    EmbreeRayPeer(const Mesh& mesh, RTCSceneFlags flags, bool closest)
        : device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)), closest_(closest)
    {
        rtcSetSceneFlags(scene_, flags);
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
        const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* const vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size()));
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
            for (int k = 0; k < 3; ++k) vertices[3 * v + std::size_t(k)] = static_cast<float>(mesh.vertices[v][k]);
        auto* const indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.triangles.size()));
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) indices[3 * t + k] = mesh.triangles[t][k];
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
    }
    ~EmbreeRayPeer() override { rtcReleaseScene(scene_), rtcReleaseDevice(device_); }
    EmbreeRayPeer(const EmbreeRayPeer&) = delete;
    EmbreeRayPeer& operator=(const EmbreeRayPeer&) = delete;

    void trace(std::span<const Segment> segments, std::span<std::uint8_t> hit) override
    {
        for (std::size_t i = 0; i < segments.size(); ++i) {
            const Eigen::Vector3f from = segments[i].from.cast<float>();
            const Eigen::Vector3f along = (segments[i].to - segments[i].from).cast<float>();
            RTCRayHit traced{};
            RTCRay& ray = traced.ray;
            ray.org_x = from.x(), ray.org_y = from.y(), ray.org_z = from.z();
            ray.dir_x = along.x(), ray.dir_y = along.y(), ray.dir_z = along.z();
            ray.tnear = 0, ray.tfar = 1, ray.mask = ~0u;
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            if (closest_) {
                traced.hit.geomID = RTC_INVALID_GEOMETRY_ID;
                rtcIntersect1(scene_, &context, &traced);
                hit[i] = traced.hit.geomID != RTC_INVALID_GEOMETRY_ID;
            } else {
                rtcOccluded1(scene_, &context, &ray);
                hit[i] = ray.tfar < 0;
            }
        }
    }

private:
    RTCDevice device_;
    RTCScene scene_;
    bool closest_;
};

RayContender contender(const char* name, const char* what, RTCSceneFlags flags, bool closest = false)
{
    return {.name = name, .what = what, .promise = Promise::approximate, .make = [flags, closest](const Mesh& mesh) {
                return std::make_unique<EmbreeRayPeer>(mesh, flags, closest);
            }};
}

} // namespace

void add_ray_embree(std::vector<RayContender>& all)
{
    all.push_back(
        contender("embree-robust", "Embree rtcOccluded1, robust scene, single precision", RTC_SCENE_FLAG_ROBUST));
    all.push_back(contender("embree", "the same, not robust", RTC_SCENE_FLAG_NONE));
    all.push_back(contender("embree-closest", "Embree rtcIntersect1, robust scene, single precision; the closest hit",
                            RTC_SCENE_FLAG_ROBUST, true));
}

} // namespace oncollide::tools
