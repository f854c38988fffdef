#pragma once
#include <cstddef>
#include <utility>

namespace oncollide {

/// Addresses for so many bytes, all zero. Memory is taken page by page when it is first written, and can be given back.
class LazyMemory {
public:
    static constexpr std::size_t page = 4096; ///< what is given back together, at least

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
    /// Zeros a range again, whose pages no longer count. It begins at a multiple of `page`, and ends at one or at the
    /// end of what is used there.
    void give_back(std::size_t begin, std::size_t size);

private:
    std::byte* bytes_ = nullptr;
    std::size_t size_ = 0;
};

} // namespace oncollide
