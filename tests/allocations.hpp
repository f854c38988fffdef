#pragma once
#include <atomic>
#include <cstddef>

namespace oncollide {
// Count if one source file of the program includes count_allocations.hpp.
inline std::atomic<std::size_t> allocations{0};
inline std::atomic<std::size_t> allocated_bytes{0};
} // namespace oncollide
