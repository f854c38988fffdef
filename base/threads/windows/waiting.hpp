// Waiting for other threads, for Windows. MinGW-w64's condition variables lose notifications: with Wine 8, a thread
// that waited for a pool of seven slept for ever. Its std::shared_mutex and std::atomic::wait() use them, too.
#pragma once
#include <atomic>
#include <cstdint>
#include <mutex>

namespace oncollide {

/// Sleeps until the word is another one, or sooner. Whoever changes it then wakes the sleepers.
void sleep_while(const std::atomic<std::uint32_t>& word, std::uint32_t value);
void wake_one(std::atomic<std::uint32_t>& word);
void wake_all(std::atomic<std::uint32_t>& word);

/// std::condition_variable, as far as the library needs it.
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
            ++sleepers_;
            sleep_while(turn_, turn);
            --sleepers_;
            lock.lock();
        }
    }
    void notify_one()
    {
        ++turn_;
        if (sleepers_ != 0) wake_one(turn_);
    }
    void notify_all()
    {
        ++turn_;
        if (sleepers_ != 0) wake_all(turn_);
    }

private:
    std::atomic<std::uint32_t> turn_{0}, sleepers_{0};
};

/// std::shared_mutex, as far as the library needs it: Windows' own lock for readers and writers.
class SharedMutex {
public:
    SharedMutex() = default;
    SharedMutex(const SharedMutex&) = delete;
    SharedMutex& operator=(const SharedMutex&) = delete;
    void lock();
    void unlock();
    void lock_shared();
    void unlock_shared();

private:
    void* lock_ = nullptr; ///< an SRWLOCK
};

} // namespace oncollide
