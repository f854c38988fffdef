#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#ifdef _WIN32
#include <oncollide/base/threads/windows/waiting.hpp>
#endif

namespace oncollide {

#ifdef _WIN32
/// The std::once_flag of MinGW-w64 waits for ever after an exception: its pthread_once() does not expect one.
struct OnceFlag {
    enum State : std::uint32_t { none, running, done };
    std::atomic<std::uint32_t> state = none;
};

template <class Make>
void call_once(OnceFlag& flag, Make make)
{
    for (;;) {
        std::uint32_t seen = flag.state.load(std::memory_order_acquire);
        if (seen == OnceFlag::done) return;
        if (seen == OnceFlag::running) {
            sleep_while(flag.state, seen);
        } else if (flag.state.compare_exchange_strong(seen, OnceFlag::running, std::memory_order_acquire)) {
            try {
                make();
            } catch (...) {
                flag.state.store(OnceFlag::none, std::memory_order_release), wake_all(flag.state);
                throw;
            }
            flag.state.store(OnceFlag::done, std::memory_order_release), wake_all(flag.state);
        }
    }
}
#else
using OnceFlag = std::once_flag;
using std::call_once;
#endif

/// A value that the first thread that needs it makes. If making throws, the next call tries again.
template <class T>
class Once {
public:
    /// @param make  returns the value
    template <class Make>
    T& get(Make make) const
    {
        if (T* const value = made()) return *value; // without the call that call_once costs
        call_once(once_, [&] {
            value_.emplace(make());
            made_.store(true, std::memory_order_release);
        });
        return *value_;
    }
    /// The value, if it was made; else null.
    T* made() const { return made_.load(std::memory_order_acquire) ? &*value_ : nullptr; }
    /// Drops the value; the next call of get() makes another one. Not concurrently with any other call.
    void reset()
    {
        std::destroy_at(this);
        std::construct_at(this);
    }

private:
    mutable OnceFlag once_;
    mutable std::optional<T> value_;
    mutable std::atomic<bool> made_ = false;
};

} // namespace oncollide
