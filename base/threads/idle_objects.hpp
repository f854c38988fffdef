#pragma once
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include <oncollide/base/threads/lock_order.hpp>

namespace oncollide {

/// Objects that are idle between calls, so that a call on any thread finds one with warm memory.
template <class T, LockRank rank>
class IdleObjects {
public:
    /// The object that was given back last; null: none is idle.
    std::unique_ptr<T> take()
    {
        const std::lock_guard lock(guard_);
        if (idle_.empty()) return nullptr;
        std::unique_ptr<T> object = std::move(idle_.back());
        idle_.pop_back();
        return object;
    }
    void give_back(std::unique_ptr<T> object)
    {
        const std::lock_guard lock(guard_);
        idle_.push_back(std::move(object));
    }

private:
    OrderedMutex<rank> guard_;
    std::vector<std::unique_ptr<T>> idle_;
};

} // namespace oncollide
