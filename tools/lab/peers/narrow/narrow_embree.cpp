// Embree's rtcCollide over the boxes of triangles as user geometry. It does not support moving instances, so the second
// mesh's boxes are computed again for every pose.
#include "peers/common/embree_boxes.hpp"
#include "peers/narrow/narrow_peer.hpp"

#include <algorithm>
#include <numeric>

#include <tbb/task_arena.h>

#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide::tools {
namespace {

TrianglePoints points(const Triangle& t, const std::vector<Eigen::Vector3d>& vertices)
{
    return {vertices[t[0]], vertices[t[1]], vertices[t[2]]};
}

Aabb box(const TrianglePoints& t)
{
    Aabb box;
    for (const Eigen::Vector3d& corner : t) box.add(corner);
    return box;
}

RTCBounds around(const RTCBounds& a, const RTCBounds& b)
{
    RTCBounds both{};
    both.lower_x = std::min(a.lower_x, b.lower_x), both.upper_x = std::max(a.upper_x, b.upper_x);
    both.lower_y = std::min(a.lower_y, b.lower_y), both.upper_y = std::max(a.upper_y, b.upper_y);
    both.lower_z = std::min(a.lower_z, b.lower_z), both.upper_z = std::max(a.upper_z, b.upper_z);
    return both;
}

/// Timed: moving the vertices, new boxes, the tree of the second mesh (refitted or rebuilt), and the exact test of all
/// pairs of boxes. Collision queries need only the first contact, but rtcCollide cannot be stopped.
class EmbreeNarrowPeer final : public NarrowPeer {
public:
    EmbreeNarrowPeer(const Mesh& a, const Mesh& b, RTCBuildQuality quality)
        : a_(a), b_(b), moved_(b.vertices), bounds_(b.vertices.size()), device_(rtcNewDevice("threads=1")), arena_(1)
    {
        arena_.execute([&] {
            boxes_a_ = std::make_unique<EmbreeBoxes>(device_, RTC_BUILD_QUALITY_MEDIUM, RTC_BUILD_QUALITY_MEDIUM,
                                                     numbers(a_.triangles.size()));
            boxes_b_ =
                std::make_unique<EmbreeBoxes>(device_, RTC_BUILD_QUALITY_LOW, quality, numbers(b_.triangles.size()));
            for (std::uint32_t i = 0; i < a_.triangles.size(); ++i)
                boxes_a_->set(i, box(points(a_.triangles[i], a_.vertices)));
            boxes_a_->commit();
            take_in(Eigen::Isometry3d::Identity());
        });
    }
    ~EmbreeNarrowPeer() override
    {
        boxes_a_.reset(), boxes_b_.reset();
        rtcReleaseDevice(device_);
    }

    bool collides(const Eigen::Isometry3d& b) override
    {
        first_only_ = true;
        search(b);
        return !found_.empty();
    }

    void all_pairs(const Eigen::Isometry3d& b, std::vector<TrianglePair>& pairs) override
    {
        first_only_ = false;
        search(b);
        pairs = found_;
    }

private:
    static std::vector<std::uint32_t> numbers(std::size_t count)
    {
        std::vector<std::uint32_t> result(count);
        std::iota(result.begin(), result.end(), 0u);
        return result;
    }

    void take_in(const Eigen::Isometry3d& b)
    {
        for (std::size_t v = 0; v < moved_.size(); ++v) {
            moved_[v] = b * b_.vertices[v];
            bounds_[v] = float_bounds({moved_[v], moved_[v]});
        }
        for (std::uint32_t j = 0; j < b_.triangles.size(); ++j) {
            const Triangle& t = b_.triangles[j];
            boxes_b_->set(j, around(around(bounds_[t[0]], bounds_[t[1]]), bounds_[t[2]]));
        }
        boxes_b_->commit();
    }

    void search(const Eigen::Isometry3d& b)
    {
        found_.clear();
        arena_.execute([&] {
            take_in(b);
            rtcCollide(boxes_a_->scene, boxes_b_->scene, take, this);
        });
    }

    static void take(void* data, RTCCollision* collisions, unsigned count)
    {
        EmbreeNarrowPeer& peer = *static_cast<EmbreeNarrowPeer*>(data);
        for (unsigned k = 0; k < count; ++k) {
            if (peer.first_only_ && !peer.found_.empty()) return;
            const std::uint32_t i = collisions[k].primID0, j = collisions[k].primID1;
            const TrianglePoints p = points(peer.a_.triangles[i], peer.a_.vertices);
            const TrianglePoints q = points(peer.b_.triangles[j], peer.moved_);
            // Embree reports the contents of overlapping leaves, not of overlapping boxes.
            if (box(p).overlaps(box(q)) && triangles_meet(p, q)) peer.found_.push_back({i, j});
        }
    }

    const Mesh &a_, &b_;
    std::vector<Eigen::Vector3d> moved_; ///< the second mesh's vertices
    std::vector<RTCBounds> bounds_;      ///< of each triangle, rounded outwards
    RTCDevice device_;
    tbb::task_arena arena_;
    std::unique_ptr<EmbreeBoxes> boxes_a_, boxes_b_;
    std::vector<TrianglePair> found_;
    bool first_only_ = false;
};

NarrowContender contender(const char* name, const char* what, RTCBuildQuality quality)
{
    return {.name = name, .what = what, .has_all_pairs = true, .make = [quality](const Mesh& a, const Mesh& b) {
                return std::make_unique<EmbreeNarrowPeer>(a, b, quality);
            }};
}

} // namespace

void add_narrow_embree(std::vector<NarrowContender>& all)
{
    all.push_back(contender("embree-refit", "Embree rtcCollide, B's tree refitted; oncollide's exact triangle test",
                            RTC_BUILD_QUALITY_REFIT));
    all.push_back(contender("embree-rebuild", "the same, B's tree rebuilt (Morton)", RTC_BUILD_QUALITY_LOW));
}

} // namespace oncollide::tools
