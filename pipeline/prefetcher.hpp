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

/// A part of a cooked mesh that bodies are about to come to.
struct PrefetchPart {
    Model* model;
    Aabb box; ///< in the model's frame
};

/// A thread that prepares parts of cooked meshes while frames are computed. It works on what was asked of it last.
class Prefetcher {
public:
    /// @param prepare  called by the thread, one part at a time
    explicit Prefetcher(std::function<void(const PrefetchPart&)> prepare);
    ~Prefetcher();
    Prefetcher(const Prefetcher&) = delete;
    Prefetcher& operator=(const Prefetcher&) = delete;

    /// In place of those that still wait. They go when their model does: Pause, and forget().
    void set(std::vector<PrefetchPart> parts);
    void forget(const Model& model);

    /// While it lives the thread is at rest. Null: there is none.
    class Pause {
    public:
        /// @param wait  for what the thread is at; else there may be no pause
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
    std::thread thread_; ///< none where there is none to be had: then nothing is prepared
};

/// Where the bodies of a World go, as far as their last motion tells.
class MotionForecast {
public:
    /// Of some of the bodies that moved, so that all get their turn within half of `frames`: the parts of cooked meshes
    /// that they meet within that time, but what was found lately. Looked up in the broad phase, which must be current.
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
    std::vector<BoxHit> hits_;
};

} // namespace oncollide
