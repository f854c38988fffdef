#pragma once
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/threads/lock_order.hpp>
#include <oncollide/narrowphase/model.hpp>

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
    OrderedMutex<LockRank::prefetcher> mutex_;
    OrderedCondition changed_;
    std::vector<PrefetchPart> parts_;
    bool busy_ = false, over_ = false;
    int paused_ = 0;
    std::thread thread_; ///< not joinable if the system grants no thread; then no part is prepared
};

} // namespace oncollide
