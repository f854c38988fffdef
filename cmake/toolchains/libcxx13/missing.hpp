// Parts of C++20 that the libc++ 13 of Emscripten 3.1.6 lacks and this project uses; the toolchain file includes it
// before every source. Definitions in namespace std are not portable in general: this file serves that one library and
// is empty for any newer one.
#pragma once
#define __asm__(...) // Eigen has empty assembly of x86 for GCC, which Clang pretends to be
#ifdef __cplusplus
#include <version>
#endif
#if __cplusplus >= 202002L && defined(_LIBCPP_VERSION) && _LIBCPP_VERSION < 14000
#include "from_chars.hpp"
#include "ranges_algorithms.hpp"

#include <cstring>
#include <memory>

namespace std {

template <class To, class From>
requires(sizeof(To) == sizeof(From) && is_trivially_copyable_v<To> && is_trivially_copyable_v<From>) constexpr To
    bit_cast(const From& from) noexcept
{
    return __builtin_bit_cast(To, from);
}

template <class Array>
requires is_unbounded_array_v<Array> unique_ptr<Array> make_unique_for_overwrite(size_t count)
{
    return unique_ptr<Array>(new remove_extent_t<Array>[count]);
}

/// T is an integer or an enumeration.
template <class T>
class atomic_ref {
public:
    explicit atomic_ref(T& of) : of_(&of) {}
    T load(memory_order = memory_order_seq_cst) const noexcept { return __atomic_load_n(of_, __ATOMIC_SEQ_CST); }
    void store(T value, memory_order = memory_order_seq_cst) const noexcept
    {
        __atomic_store_n(of_, value, __ATOMIC_SEQ_CST);
    }
    bool compare_exchange_strong(T& expected, T wanted, memory_order = memory_order_seq_cst) const noexcept
    {
        return __atomic_compare_exchange_n(of_, &expected, wanted, false, __ATOMIC_SEQ_CST, __ATOMIC_SEQ_CST);
    }

private:
    T* of_;
};
template <class T>
atomic_ref(T&) -> atomic_ref<T>;

} // namespace std
#endif
