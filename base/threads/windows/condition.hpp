#pragma once
#include <atomic>
#include <cstdint>
#include <mutex>

namespace oncollide {

/// std::condition_variable for Windows, as far as the library needs it. MinGW-w64's own loses notifications: with Wine
/// 8, a thread that waited for a pool of seven slept for ever.
///
/// Each notification changes `turn_`. A thread reads it while it holds the lock, and sleeps only while it is unchanged,
/// so no notification comes between unlocking and sleeping. Waking nobody would be a system call, too, so sleepers are
/// counted: a notification either sees a sleeper, or the sleeper sees the new turn.
class Condition {
public:
    template <class Mutex, class Ready>
    void wait(std::unique_lock<Mutex>& lock, const Ready& ready)
    {
        while (!ready()) {
            const std::uint32_t turn = turn_.load();
            lock.unlock();
            sleep(turn);
            lock.lock();
        }
    }
    void notify_one();
    void notify_all();

private:
    /// Until the turn is another one, or sooner.
    void sleep(std::uint32_t turn);

    std::atomic<std::uint32_t> turn_{0}, sleepers_{0};
};

} // namespace oncollide
