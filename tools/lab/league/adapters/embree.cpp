// Embree: rays against triangles, with and without its robust mode, and pairs of boxes by rtcCollide. Single precision.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <utility>
#include <vector>

#include <embree3/rtcore.h>

#include "common.hpp"

namespace {

/// A device of one thread and a scene.
struct Scene : league::Query {
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene scene = nullptr;

    Scene()
    {
        if (!device) throw std::runtime_error("no device");
        scene = rtcNewScene(device);
    }
    ~Scene() override
    {
        if (scene) rtcReleaseScene(scene);
        if (device) rtcReleaseDevice(device);
    }

    /// The scene owns it after this.
    void take(RTCGeometry geometry) const
    {
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene);
        if (rtcGetDeviceError(device) != RTC_ERROR_NONE) throw std::runtime_error("Embree reports an error");
    }
};

struct Rays final : Scene {
    Rays(const league_case& asked, RTCSceneFlags flags)
    {
        const league_body& body = asked.a;
        rtcSetSceneFlags(scene, flags);
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
        const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* const vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), body.vertex_count));
        auto* const indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), body.triangle_count));
        if (!vertices || !indices) {
            rtcReleaseGeometry(geometry);
            throw std::bad_alloc();
        }
        for (std::size_t v = 0; v < body.vertex_count; ++v) {
            const double* p = body.vertices + 3 * v;
            const league::Vector at = league::to_world(body, {p[0], p[1], p[2]});
            std::transform(at.begin(), at.end(), vertices + 3 * v, [](double x) { return static_cast<float>(x); });
        }
        std::copy_n(body.triangles, 3 * body.triangle_count, indices);
        take(geometry);
    }

    int answer(const league_case& asked, league_answer& answer) override
    {
        const auto number = [](double x) { return static_cast<float>(x); };
        RTCRayHit traced{};
        RTCRay& ray = traced.ray;
        ray.org_x = number(asked.from[0]), ray.org_y = number(asked.from[1]), ray.org_z = number(asked.from[2]);
        ray.dir_x = number(asked.motion[0]), ray.dir_y = number(asked.motion[1]), ray.dir_z = number(asked.motion[2]);
        ray.tnear = 0, ray.tfar = 1, ray.mask = ~0u;
        traced.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene, &context, &traced);
        answer.meet = traced.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        if (answer.meet) answer.time = double(ray.tfar);
        return LEAGUE_ANSWERED;
    }
};

float float_below(double x)
{
    const float f = static_cast<float>(x);
    return double(f) <= x ? f : std::nextafter(f, -std::numeric_limits<float>::infinity());
}

/// In a dynamic scene of low quality each leaf has one box, and Embree reports the pairs of boxes that overlap. In
/// others it reports all pairs of two leaves that overlap.
struct Boxes final : Scene {
    std::vector<RTCBounds> bounds;
    std::mutex one_at_a_time;
    std::vector<std::uint32_t> pairs;

    explicit Boxes(const league_case& asked)
    {
        for (std::size_t i = 0; i < asked.body_count; ++i) {
            const league_body& body = asked.bodies[i];
            const auto low = [&](int k) { return float_below(body.position[k] - body.size[k]); };
            const auto high = [&](int k) { return -float_below(-body.position[k] - body.size[k]); };
            RTCBounds b{};
            b.lower_x = low(0), b.lower_y = low(1), b.lower_z = low(2);
            b.upper_x = high(0), b.upper_y = high(1), b.upper_z = high(2);
            bounds.push_back(b);
        }
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_DYNAMIC);
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW);
        const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_LOW);
        rtcSetGeometryUserPrimitiveCount(geometry, unsigned(bounds.size()));
        rtcSetGeometryUserData(geometry, this);
        rtcSetGeometryBoundsFunction(geometry, give_bounds, nullptr);
        take(geometry);
    }

    static void give_bounds(const RTCBoundsFunctionArguments* arguments)
    {
        *arguments->bounds_o = static_cast<const Boxes*>(arguments->geometryUserPtr)->bounds[arguments->primID];
    }

    /// Embree reports each pair in both orders, and may call from several threads.
    static void keep(void* data, RTCCollision* collisions, unsigned count)
    {
        Boxes& boxes = *static_cast<Boxes*>(data);
        const std::lock_guard lock(boxes.one_at_a_time);
        for (unsigned k = 0; k < count; ++k)
            if (const auto [a, b] = std::pair(collisions[k].primID0, collisions[k].primID1); a < b)
                boxes.pairs.push_back(a), boxes.pairs.push_back(b);
    }

    int answer(const league_case&, league_answer& answer) override
    {
        pairs.clear();
        rtcCollide(scene, scene, keep, this);
        answer.pair_count = pairs.size() / 2;
        answer.pairs = pairs.data();
        return LEAGUE_ANSWERED;
    }
};

int supports(int question, int kind_a, int)
{
    return question == LEAGUE_PAIRS || (question == LEAGUE_RAY && league::has_triangles(kind_a));
}

/// Rays only against surfaces: a hit from inside is not Embree's matter.
template <RTCSceneFlags flags>
std::unique_ptr<league::Query> prepare(const league_case& asked)
{
    if (league::needs_inside(asked)) return nullptr;
    if (asked.question == LEAGUE_RAY) return std::make_unique<Rays>(asked, flags);
    return std::make_unique<Boxes>(asked);
}

template <RTCSceneFlags flags>
constexpr league_library embree(const char* name, const char* settings)
{
    return league::library_of<prepare<flags>>(
        {.name = name, .settings = settings, .source = "embree3/rtcore_scene.h", .supports = supports, .bits = 32});
}

#define LEAGUE_EMBREE_USE(flags)                                                                                       \
    RTC_VERSION_STRING "; single precision; rtcIntersect1, " #flags "; rtcCollide of a dynamic scene"

constexpr league_library libraries[] = {
    embree<RTC_SCENE_FLAG_ROBUST>("embree-robust", LEAGUE_EMBREE_USE(RTC_SCENE_FLAG_ROBUST)),
    embree<RTC_SCENE_FLAG_NONE>("embree", LEAGUE_EMBREE_USE(RTC_SCENE_FLAG_NONE)),
};

} // namespace

const league_library* league_open(int number)
{
    return league::library_at(libraries, number);
}
