// Code that all files about Embree share.
#pragma once
#include "peers/peers.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <embree3/rtcore.h>

#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide::tools {

void add_embree_deform(Contenders& all);

namespace embree_boxes {

inline float float_below(double x)
{
    const float f = static_cast<float>(x);
    return f <= x ? f : std::nextafter(f, -std::numeric_limits<float>::infinity());
}
inline float float_above(double x)
{
    return -float_below(-x);
}

/// The box, rounded outwards.
inline RTCBounds float_bounds(const Aabb& box)
{
    RTCBounds b{};
    b.lower_x = float_below(box.min.x()), b.lower_y = float_below(box.min.y()), b.lower_z = float_below(box.min.z());
    b.upper_x = float_above(box.max.x()), b.upper_y = float_above(box.max.y()), b.upper_z = float_above(box.max.z());
    return b;
}

inline RTCBounds around(const RTCBounds& a, const RTCBounds& b)
{
    RTCBounds both{};
    both.lower_x = std::min(a.lower_x, b.lower_x), both.upper_x = std::max(a.upper_x, b.upper_x);
    both.lower_y = std::min(a.lower_y, b.lower_y), both.upper_y = std::max(a.upper_y, b.upper_y);
    both.lower_z = std::min(a.lower_z, b.lower_z), both.upper_z = std::max(a.upper_z, b.upper_z);
    return both;
}

/// Some of the boxes as an Embree scene. Embree uses a geometry's build quality only in scenes of low quality: "refit"
/// then builds a good tree once, "low" a Morton tree every time. In other scenes all trees are rebuilt at high quality.
class EmbreeBoxes {
public:
    EmbreeBoxes(RTCDevice device, RTCBuildQuality scene_quality, RTCBuildQuality quality,
                std::vector<std::uint32_t> numbers)
        : members(std::move(numbers)), scene(rtcNewScene(device)),
          geometry_(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER)), bounds_(members.size())
    {
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_DYNAMIC);
        rtcSetSceneBuildQuality(scene, scene_quality);
        rtcSetGeometryBuildQuality(geometry_, quality);
        rtcSetGeometryUserPrimitiveCount(geometry_, unsigned(members.size()));
        rtcSetGeometryUserData(geometry_, this);
        rtcSetGeometryBoundsFunction(geometry_, give_bounds, nullptr);
        rtcAttachGeometry(scene, geometry_);
    }
    ~EmbreeBoxes() { rtcReleaseGeometry(geometry_), rtcReleaseScene(scene); }
    EmbreeBoxes(const EmbreeBoxes&) = delete;
    EmbreeBoxes& operator=(const EmbreeBoxes&) = delete;

    void set(std::uint32_t member, const Aabb& box) { set(member, float_bounds(box)); }
    void set(std::uint32_t member, const RTCBounds& bounds) { bounds_[member] = bounds; }

    /// The boxes of triangles, by member. @param bounds  working memory
    void set_triangles(std::span<const Triangle> triangles, std::span<const Eigen::Vector3d> vertices,
                       std::vector<RTCBounds>& bounds)
    {
        bounds.resize(vertices.size());
        for (std::size_t v = 0; v < vertices.size(); ++v) bounds[v] = float_bounds({vertices[v], vertices[v]});
        for (std::uint32_t i = 0; i < triangles.size(); ++i) {
            const Triangle& t = triangles[i];
            set(i, around(around(bounds[t[0]], bounds[t[1]]), bounds[t[2]]));
        }
    }

    void commit()
    {
        rtcCommitGeometry(geometry_);
        rtcCommitScene(scene);
    }

    const std::vector<std::uint32_t> members; ///< indices of the boxes
    const RTCScene scene;

private:
    static void give_bounds(const RTCBoundsFunctionArguments* arguments)
    {
        *arguments->bounds_o = static_cast<const EmbreeBoxes*>(arguments->geometryUserPtr)->bounds_[arguments->primID];
    }

    RTCGeometry geometry_;
    std::vector<RTCBounds> bounds_; ///< by member
};

inline TrianglePoints points_of(const Triangle& t, const std::vector<Eigen::Vector3d>& vertices)
{
    return {vertices[t[0]], vertices[t[1]], vertices[t[2]]};
}

inline Aabb box_of(const TrianglePoints& t)
{
    Aabb box;
    for (const Eigen::Vector3d& corner : t) box.add(corner);
    return box;
}

inline std::vector<std::uint32_t> numbers(std::size_t count)
{
    std::vector<std::uint32_t> result(count);
    std::iota(result.begin(), result.end(), 0u);
    return result;
}

} // namespace embree_boxes
} // namespace oncollide::tools
