// Embree on meshes that deform.
#include "peers/embree_boxes.hpp"

#include <tbb/task_arena.h>

namespace oncollide::tools {

using namespace embree_boxes;

namespace {

/// New boxes of the triangles, the tree refitted; rtcCollide, and the exact test of all pairs of boxes.
class EmbreeDeformPeer final : public DeformPeer {
public:
    EmbreeDeformPeer(const Mesh& a, const Mesh& b, RTCBuildQuality quality)
        : device_(rtcNewDevice("threads=1")), arena_(1), sides_{{a.triangles}, {b.triangles}}
    {
        arena_.execute([&] {
            for (Side& side : sides_)
                side.boxes = std::make_unique<EmbreeBoxes>(device_, RTC_BUILD_QUALITY_LOW, quality,
                                                           numbers(side.triangles.size()));
        });
        set_vertices(0, a.vertices), set_vertices(1, b.vertices);
    }
    ~EmbreeDeformPeer() override
    {
        for (Side& side : sides_) side.boxes.reset();
        rtcReleaseDevice(device_);
    }

    void set_vertices(int which, std::span<const Eigen::Vector3d> positions) override
    {
        Side& side = sides_[which];
        side.vertices.assign(positions.begin(), positions.end());
        arena_.execute([&] {
            side.boxes->set_triangles(side.triangles, side.vertices, bounds_);
            side.boxes->commit();
        });
    }
    void all_pairs(std::vector<TrianglePair>& pairs) override
    {
        pairs.clear();
        found_ = &pairs;
        arena_.execute([&] { rtcCollide(sides_[0].boxes->scene, sides_[1].boxes->scene, take, this); });
    }

private:
    struct Side {
        const std::vector<Triangle>& triangles;
        std::vector<Eigen::Vector3d> vertices{};
        std::unique_ptr<EmbreeBoxes> boxes{};
    };
    static void take(void* data, RTCCollision* collisions, unsigned count)
    {
        EmbreeDeformPeer& peer = *static_cast<EmbreeDeformPeer*>(data);
        const Side &a = peer.sides_[0], &b = peer.sides_[1];
        for (const RTCCollision& c : std::span(collisions, count)) {
            const TrianglePoints p = points_of(a.triangles[c.primID0], a.vertices);
            const TrianglePoints q = points_of(b.triangles[c.primID1], b.vertices);
            if (box_of(p).overlaps(box_of(q)) && triangles_meet(p, q)) peer.found_->push_back({c.primID0, c.primID1});
        }
    }

    RTCDevice device_;
    tbb::task_arena arena_;
    Side sides_[2];
    std::vector<RTCBounds> bounds_;
    std::vector<TrianglePair>* found_ = nullptr;
};

} // namespace

void add_embree_deform(Contenders& all)
{
    all.deform.all.push_back({.name = "embree-refit",
                              .what = "Embree rtcCollide, trees refitted; oncollide's exact triangle test",
                              .make = maker<EmbreeDeformPeer>(RTC_BUILD_QUALITY_REFIT)});
    all.deform.all.push_back({.name = "embree-rebuild",
                              .what = "the same, trees rebuilt (Morton)",
                              .make = maker<EmbreeDeformPeer>(RTC_BUILD_QUALITY_LOW)});
}

} // namespace oncollide::tools
