// Embree's rtcCollide over boxes as user geometry. Static boxes have their own scene, built once.
#include "peers/broad/broad_peer.hpp"
#include "peers/common/embree_boxes.hpp"

#include <array>
#include <atomic>
#include <string>

#include <tbb/task_arena.h>

namespace oncollide::tools {
namespace {

/// Embree calls back from several threads, so each thread collects its own pairs. Threads are few and live until exit.
constexpr std::size_t most_threads = 256;
std::size_t thread_slot()
{
    static std::atomic<std::size_t> seen = 0;
    thread_local const std::size_t slot = seen++;
    return slot % most_threads;
}

class EmbreePeer final : public BroadPeer {
public:
    EmbreePeer(RTCBuildQuality quality, int threads)
        : quality_(quality), device_(rtcNewDevice(("threads=" + std::to_string(threads)).c_str())), arena_(threads)
    {
    }
    ~EmbreePeer() override
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
        EmbreePeer& peer;
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

BroadContender contender(const char* name, const char* what, RTCBuildQuality quality)
{
    return {.name = name, .what = what, .threaded = true, .make = [quality](int threads) {
                return std::make_unique<EmbreePeer>(quality, threads);
            }};
}

} // namespace

void add_embree(std::vector<BroadContender>& all)
{
    all.push_back(contender("embree-rebuild", "Embree rtcCollide, Morton tree rebuilt", RTC_BUILD_QUALITY_LOW));
    all.push_back(contender("embree-refit", "Embree rtcCollide, tree refitted", RTC_BUILD_QUALITY_REFIT));
}

} // namespace oncollide::tools
