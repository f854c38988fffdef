#pragma once
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include <embree3/rtcore.h>

#include <oncollide/base/aabb.hpp>

namespace oncollide::tools {

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

} // namespace oncollide::tools
