// Embree's rtcCollide over boxes as user geometry, and its tests of rays against triangle meshes.
#include "peers/embree_boxes.hpp"

#include <array>
#include <atomic>
#include <cmath>

#include <tbb/task_arena.h>

namespace oncollide::tools {

using namespace embree_boxes;

namespace {

/// Embree calls back from several threads, so each thread collects its own pairs. Threads are few and live until exit.
constexpr std::size_t most_threads = 256;
std::size_t thread_slot()
{
    static std::atomic<std::size_t> seen = 0;
    thread_local const std::size_t slot = seen++;
    return slot % most_threads;
}

/// Static boxes have their own scene, built once.
class EmbreeBroadPeer final : public BroadPeer {
public:
    EmbreeBroadPeer(RTCBuildQuality quality, int threads)
        : quality_(quality), device_(rtcNewDevice(("threads=" + std::to_string(threads)).c_str())), arena_(threads)
    {
    }
    ~EmbreeBroadPeer() override
    {
        movers_.reset(), statics_.reset();
        rtcReleaseDevice(device_);
    }

    void start(const BoxFrame& frame) override
    {
        arena_.execute([&] { build(frame); });
    }

    void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) override
    {
        for (auto& part : parts_) part.clear();
        arena_.execute([&] {
            for (std::uint32_t i : frame.moved) movers_->set(member_[i], frame.boxes[i]);
            movers_->commit();
            collide(frame, *movers_, *movers_);
            if (statics_) collide(frame, *movers_, *statics_);
        });
        pairs.clear();
        for (const auto& part : parts_) pairs.insert(pairs.end(), part.begin(), part.end());
    }

private:
    void build(const BoxFrame& frame)
    {
        std::vector<std::uint32_t> movers, statics;
        for (std::uint32_t i = 0; i < frame.boxes.size(); ++i) {
            std::vector<std::uint32_t>& members = frame.is_static[i] ? statics : movers;
            member_.push_back(std::uint32_t(members.size()));
            members.push_back(i);
        }
        movers_ = make(frame, RTC_BUILD_QUALITY_LOW, quality_, std::move(movers));
        if (!statics.empty())
            statics_ = make(frame, RTC_BUILD_QUALITY_MEDIUM, RTC_BUILD_QUALITY_MEDIUM, std::move(statics));
    }

    std::unique_ptr<EmbreeBoxes> make(const BoxFrame& frame, RTCBuildQuality scene_quality, RTCBuildQuality quality,
                                      std::vector<std::uint32_t> members) const
    {
        auto made = std::make_unique<EmbreeBoxes>(device_, scene_quality, quality, std::move(members));
        for (std::uint32_t i : made->members) made->set(member_[i], frame.boxes[i]);
        made->commit();
        return made;
    }

    struct Search {
        EmbreeBroadPeer& peer;
        const BoxFrame& frame;
        const EmbreeBoxes &a, &b;
        bool exact; ///< each leaf has one box, so all reported pairs overlap
    };

    void collide(const BoxFrame& frame, const EmbreeBoxes& a, const EmbreeBoxes& b)
    {
        Search search{*this, frame, a, b, &a == &b && quality_ == RTC_BUILD_QUALITY_LOW};
        rtcCollide(a.scene, b.scene, take, &search);
    }

    /// Embree reports the contents of overlapping leaves; within one scene it reports each pair in both orders.
    static void take(void* data, RTCCollision* collisions, unsigned count)
    {
        const Search& q = *static_cast<const Search*>(data);
        std::vector<BodyPair>& pairs = q.peer.parts_[thread_slot()];
        for (const RTCCollision& c : std::span(collisions, count)) {
            const std::uint32_t a = q.a.members[c.primID0], b = q.b.members[c.primID1];
            if ((&q.a != &q.b || a < b) && (q.exact || q.frame.boxes[a].overlaps(q.frame.boxes[b])))
                pairs.push_back({a, b});
        }
    }

    RTCBuildQuality quality_;
    RTCDevice device_;
    tbb::task_arena arena_; ///< limits threads; Embree's own limit changes with every device
    std::unique_ptr<EmbreeBoxes> movers_, statics_;
    std::vector<std::uint32_t> member_; ///< by box, its index among the moving or the static boxes
    std::array<std::vector<BodyPair>, most_threads> parts_;
};

/// It does not support moving instances, so the second mesh's boxes are computed again for every pose. Timed: moving
/// the vertices, new boxes, the tree of the second mesh (refitted or rebuilt), and the exact test of all pairs of
/// boxes. Collision queries need only the first contact, but rtcCollide cannot be stopped.
class EmbreeNarrowPeer final : public NarrowPeer {
public:
    EmbreeNarrowPeer(const Mesh& a, const Mesh& b, RTCBuildQuality quality)
        : a_(a), b_(b), moved_(b.vertices), device_(rtcNewDevice("threads=1")), arena_(1)
    {
        arena_.execute([&] {
            boxes_a_ = std::make_unique<EmbreeBoxes>(device_, RTC_BUILD_QUALITY_MEDIUM, RTC_BUILD_QUALITY_MEDIUM,
                                                     numbers(a_.triangles.size()));
            boxes_b_ =
                std::make_unique<EmbreeBoxes>(device_, RTC_BUILD_QUALITY_LOW, quality, numbers(b_.triangles.size()));
            for (std::uint32_t i = 0; i < a_.triangles.size(); ++i)
                boxes_a_->set(i, box_of(points_of(a_.triangles[i], a_.vertices)));
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
    void take_in(const Eigen::Isometry3d& b)
    {
        for (std::size_t v = 0; v < moved_.size(); ++v) moved_[v] = b * b_.vertices[v];
        boxes_b_->set_triangles(b_.triangles, moved_, bounds_);
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
            const TrianglePoints p = points_of(peer.a_.triangles[i], peer.a_.vertices);
            const TrianglePoints q = points_of(peer.b_.triangles[j], peer.moved_);
            // Embree reports the contents of overlapping leaves, not of overlapping boxes.
            if (box_of(p).overlaps(box_of(q)) && triangles_meet(p, q)) peer.found_.push_back({i, j});
        }
    }

    const Mesh &a_, &b_;
    std::vector<Eigen::Vector3d> moved_; ///< the second mesh's vertices
    std::vector<RTCBounds> bounds_;      ///< working memory
    RTCDevice device_;
    tbb::task_arena arena_;
    std::unique_ptr<EmbreeBoxes> boxes_a_, boxes_b_;
    std::vector<TrianglePair> found_;
    bool first_only_ = false;
};

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

} // namespace

void add_embree(Contenders& all)
{
    add_embree_deform(all);
    const auto add_broad = [&](const char* name, const char* what, RTCBuildQuality quality) {
        all.broad.all.push_back({.name = name, .what = what, .threaded = true, .make = [quality](int threads) {
                                     return std::make_unique<EmbreeBroadPeer>(quality, threads);
                                 }});
    };
    const auto add_narrow = [&](const char* name, const char* what, RTCBuildQuality quality) {
        all.narrow.all.push_back(
            {.name = name, .what = what, .has_all_pairs = true, .make = maker<EmbreeNarrowPeer>(quality)});
    };
    const auto add_rays = [&](const char* name, const char* what, RTCSceneFlags flags, bool closest) {
        all.rays.all.push_back({.name = name,
                                .what = what,
                                .promise = Promise::approximate,
                                .make = maker<EmbreeRayPeer>(flags, closest)});
    };
    add_broad("embree-rebuild", "Embree rtcCollide, Morton tree rebuilt", RTC_BUILD_QUALITY_LOW);
    add_broad("embree-refit", "Embree rtcCollide, tree refitted", RTC_BUILD_QUALITY_REFIT);
    add_narrow("embree-refit", "Embree rtcCollide, B's tree refitted; oncollide's exact triangle test",
               RTC_BUILD_QUALITY_REFIT);
    add_narrow("embree-rebuild", "the same, B's tree rebuilt (Morton)", RTC_BUILD_QUALITY_LOW);
    add_rays("embree-robust", "Embree rtcOccluded1, robust scene, single precision", RTC_SCENE_FLAG_ROBUST, false);
    add_rays("embree", "the same, not robust", RTC_SCENE_FLAG_NONE, false);
    add_rays("embree-closest", "Embree rtcIntersect1, robust scene, single precision; the closest hit",
             RTC_SCENE_FLAG_ROBUST, true);
}

} // namespace oncollide::tools
