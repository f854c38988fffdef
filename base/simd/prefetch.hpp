#pragma once
#include <cstddef>

namespace oncollide {

/// Prefetches the cache line at an address, which need not be valid. The empty asm statement is needed: otherwise GCC
/// considers the function free of effects and removes calls of it.
inline void prefetch(const void* at)
{
    __builtin_prefetch(at);
    asm volatile("");
}
/// Prefetches a range of bytes at any alignment.
inline void prefetch(const void* from, std::size_t bytes)
{
    constexpr std::size_t line = 64;
    for (std::size_t at = 0; at < bytes; at += line) prefetch(static_cast<const char*>(from) + at);
    prefetch(static_cast<const char*>(from) + bytes - 1);
}
template <class T>
void prefetch_all_of(const T& object)
{
    prefetch(&object, sizeof object);
}

} // namespace oncollide
