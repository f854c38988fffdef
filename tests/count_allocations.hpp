// Counts the allocations of a program, for functions that promise to allocate nothing. Include it in one source file of
// a program. Sanitizers replace the operators, and assertions examine structures with memory of their own: then nothing
// is counted.
#pragma once
#include <cstdlib>
#include <new>

#include "allocations.hpp"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(ONCOLLIDE_ASSERTIONS)
[[gnu::noinline]] void* operator new(std::size_t size)
{
    ++oncollide::allocations, oncollide::allocated_bytes += size;
    if (void* memory = std::malloc(size ? size : 1)) return memory;
    throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept
{
    std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept
{
    std::free(memory);
}
#endif
