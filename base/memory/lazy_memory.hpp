#pragma once
#include <cstddef>
#include <utility>

namespace oncollide {

/// Zeroed address space. A page uses memory from the first write until it is given back.
class LazyMemory {
public:
    static constexpr std::size_t page = 4096; ///< granularity of give_back(), bytes

    LazyMemory() = default;
    /// Throws std::bad_alloc.
    explicit LazyMemory(std::size_t bytes);
    ~LazyMemory();
    LazyMemory(LazyMemory&& other) noexcept
        : bytes_(std::exchange(other.bytes_, nullptr)), size_(std::exchange(other.size_, 0))
    {
    }
    LazyMemory& operator=(LazyMemory&& other) noexcept
    {
        std::swap(bytes_, other.bytes_), std::swap(size_, other.size_);
        return *this;
    }

    std::byte* data() const { return bytes_; }
    /// Zeros a range and returns its pages to the system. `begin` must be a multiple of `page`; the end must be one
    /// too, or the end of the used part.
    void give_back(std::size_t begin, std::size_t size);

private:
    std::byte* bytes_ = nullptr;
    std::size_t size_ = 0;
};

} // namespace oncollide
