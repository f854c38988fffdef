#include <oncollide/base/threads/windows/waiting.hpp>

#include <windows.h>

namespace oncollide {
namespace {

SRWLOCK* system_lock(void*& lock)
{
    static_assert(sizeof(SRWLOCK) == sizeof lock);
    return reinterpret_cast<SRWLOCK*>(&lock);
}

} // namespace

void sleep_while(const std::atomic<std::uint32_t>& word, std::uint32_t value)
{
    static_assert(sizeof word == sizeof value);
    WaitOnAddress(const_cast<std::atomic<std::uint32_t>*>(&word), &value, sizeof value, INFINITE);
}

void wake_one(std::atomic<std::uint32_t>& word)
{
    WakeByAddressSingle(&word);
}

void wake_all(std::atomic<std::uint32_t>& word)
{
    WakeByAddressAll(&word);
}

void SharedMutex::lock()
{
    AcquireSRWLockExclusive(system_lock(lock_));
}

void SharedMutex::unlock()
{
    ReleaseSRWLockExclusive(system_lock(lock_));
}

void SharedMutex::lock_shared()
{
    AcquireSRWLockShared(system_lock(lock_));
}

void SharedMutex::unlock_shared()
{
    ReleaseSRWLockShared(system_lock(lock_));
}

} // namespace oncollide
