#include <oncollide/base/memory/lazy_memory.hpp>

#include <algorithm>
#include <cstring>
#include <new>

#include <sys/mman.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

LazyMemory::LazyMemory(std::size_t bytes) : size_(std::max<std::size_t>((bytes + page - 1) / page * page, page))
{
    int flags = MAP_PRIVATE | MAP_ANONYMOUS;
#if defined(MAP_NORESERVE)
    flags |= MAP_NORESERVE;
#endif
    void* const memory = mmap(nullptr, size_, PROT_READ | PROT_WRITE, flags, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    bytes_ = static_cast<std::byte*>(memory);
#if defined(__linux__)
    madvise(memory, size_, MADV_NOHUGEPAGE); // the first write would allocate a whole huge page
#endif
}

LazyMemory::~LazyMemory()
{
    if (bytes_) munmap(bytes_, size_);
}

void LazyMemory::give_back(std::size_t begin, std::size_t size)
{
    ONCOLLIDE_ASSERT(begin % page == 0 && begin < size_);
    size = std::min((size + page - 1) / page * page, size_ - begin);
#if defined(__linux__)
    if (madvise(bytes_ + begin, size, MADV_DONTNEED) == 0) return; // other systems may keep the bytes
#endif
    std::memset(bytes_ + begin, 0, size);
}

} // namespace oncollide
