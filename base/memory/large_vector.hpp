#pragma once
#include <cstddef>
#include <cstdint>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace oncollide {

/// Asks the system for huge pages in this memory: a hint, which it may refuse.
void advise_huge_pages(void* memory, std::size_t bytes);

/// Allocator for memory with random access: large blocks use huge pages if the system grants them, which reduces TLB
/// misses.
template <class T>
struct LargeAllocator {
    using value_type = T;
    static constexpr std::size_t huge_page = std::size_t{2} << 20;

    LargeAllocator() = default;
    template <class U>
    LargeAllocator(const LargeAllocator<U>&) // NOLINT: allocators convert
    {
    }
    T* allocate(std::size_t count)
    {
        const std::size_t bytes = count * sizeof(T);
        if (!large(count)) return static_cast<T*>(::operator new(bytes));
        void* memory = ::operator new (bytes, std::align_val_t{huge_page});
        advise_huge_pages(memory, bytes);
        return static_cast<T*>(memory);
    }
    void deallocate(T* memory, std::size_t count)
    {
        if (large(count))
            ::operator delete (memory, std::align_val_t{huge_page});
        else
            ::operator delete(memory);
    }
    friend bool operator==(const LargeAllocator&, const LargeAllocator&) { return true; }

private:
    static bool large(std::size_t count) { return count * sizeof(T) >= 2 * huge_page; }
};

/// As advise_huge_pages(), for the huge pages that lie wholly in this memory.
inline void advise_huge_pages_in(void* memory, std::size_t bytes)
{
    constexpr std::size_t huge_page = LargeAllocator<std::byte>::huge_page;
    const std::size_t begin = reinterpret_cast<std::uintptr_t>(memory);
    const std::size_t first = (begin + huge_page - 1) / huge_page * huge_page,
                      last = (begin + bytes) / huge_page * huge_page;
    if (first < last) advise_huge_pages(reinterpret_cast<void*>(first), last - first);
}

/// Reserves room for `count` elements in a vector with another allocator; large blocks use huge pages, which reduces
/// page faults.
template <class T>
void reserve_large(std::vector<T>& vector, std::size_t count)
{
    vector.reserve(count);
    advise_huge_pages_in(vector.data(), count * sizeof(T));
}

/// push_back() that grows with reserve_large(), for vectors of unknown final size.
template <class T>
void append_large(std::vector<T>& vector, std::type_identity_t<T> value)
{
    if (vector.size() == vector.capacity()) reserve_large(vector, 2 * vector.size() + 16);
    vector.push_back(std::move(value));
}

template <class T>
using LargeVector = std::vector<T, LargeAllocator<T>>;

/// Reserves room for `count` elements: exactly if the vector is empty, else with an eighth to spare, as it grows often.
template <class T>
void reserve_ahead(LargeVector<T>& vector, std::size_t count)
{
    if (count > vector.capacity()) vector.reserve(vector.empty() ? count : count + count / 8);
}

} // namespace oncollide
