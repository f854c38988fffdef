#pragma once
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <thread>
#include <unordered_map>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/pipeline/bodies.hpp>

namespace oncollide {

/// A part of a cooked mesh that bodies are expected to reach soon.
struct PrefetchPart {
    Model* model;
    Aabb box; ///< in the model's frame
};

/// A thread that prepares parts of cooked meshes while frames are computed. New requests replace waiting ones.
class Prefetcher {
public:
    /// @param prepare  called by the thread, one part at a time
    explicit Prefetcher(std::function<void(const PrefetchPart&)> prepare);
    ~Prefetcher();
    Prefetcher(const Prefetcher&) = delete;
    Prefetcher& operator=(const Prefetcher&) = delete;

    /// Replaces the waiting parts. Before a model is destroyed, call forget() during a Pause.
    void set(std::vector<PrefetchPart> parts);
    void forget(const Model& model);

    /// The thread is idle while this object lives. Null: no effect.
    class Pause {
    public:
        /// @param wait  wait until the thread is idle; otherwise the pause fails if the thread is busy
        explicit Pause(Prefetcher* of, bool wait = true);
        ~Pause();
        bool failed() const { return failed_; }
        Pause(const Pause&) = delete;
        Pause& operator=(const Pause&) = delete;

    private:
        Prefetcher* of_;
        bool failed_ = false;
    };

private:
    void run();

    std::function<void(const PrefetchPart&)> prepare_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<PrefetchPart> parts_;
    bool busy_ = false, over_ = false;
    int paused_ = 0;
    std::thread thread_; ///< not joinable if the system grants no thread; then no part is prepared
};

/// Predicts the motion of bodies by linear extrapolation.
class MotionForecast {
public:
    /// Parts of cooked meshes that moving bodies reach within `frames` frames, except parts found recently. Each call
    /// examines a share of the bodies; all are examined within `frames` / 2 calls. The broad phase must be up to date.
    std::vector<PrefetchPart> find(const Bodies& bodies, std::span<const std::uint32_t> moved, const BroadPhase& broad,
                                   std::uint32_t frame, std::uint32_t frames);

private:
    struct Seen {
        Eigen::Vector3d centre;
        std::uint32_t frame = ~0u; ///< never
    };
    bool found_lately(const PrefetchPart& part) const;

    std::vector<Seen> seen_; ///< by slot
    std::unordered_map<const Model*, Aabb> found_;
    std::uint32_t found_since_ = 0;
    std::vector<std::uint32_t> slots_;
    std::vector<Aabb> boxes_;
    std::vector<AabbHit> hits_;
};

} // namespace oncollide
