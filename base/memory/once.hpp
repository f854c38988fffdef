#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>

namespace oncollide {

/// A value that the first thread that needs it makes. If making throws, the next call tries again.
template <class T>
class Once {
public:
    /// @param make  returns the value
    template <class Make>
    T& get(Make make) const
    {
        if (T* const value = made()) return *value; // without the call that call_once costs
        std::call_once(once_, [&] {
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
    mutable std::once_flag once_;
    mutable std::optional<T> value_;
    mutable std::atomic<bool> made_ = false;
};

} // namespace oncollide
