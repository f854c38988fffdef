#pragma once
#include <cstddef>

namespace oncollide {

/// Begins to load what is at an address, for a look at it later; it need not be there. The empty statement stays: GCC
/// takes a function that does nothing but prefetch for one that does nothing, and leaves out calls of it.
inline void prefetch(const void* at)
{
    __builtin_prefetch(at);
    asm volatile("");
}
/// So many bytes, be they aligned or not.
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
