#include <oncollide/base/memory/lazy_memory.hpp>

#include <algorithm>
#include <mutex>
#include <new>
#include <shared_mutex>
#include <vector>

#include <windows.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/windows/waiting.hpp>

// Windows grants committed memory only as far as the machine and its page file have it, also while it is untouched. The
// class therefore reserves addresses, and a handler of access violations commits a block at its first use. System calls
// do not reach the handler, so they must not be given this memory.
namespace oncollide {

namespace {

constexpr std::size_t block = std::size_t{1} << 16; // bytes; addresses are reserved by multiples of it

struct Range {
    std::byte* begin;
    std::size_t size;
};

class Ranges {
public:
    void add(Range range)
    {
        const std::lock_guard lock(mutex_);
        ranges_.push_back(range);
        if (!handler_) handler_ = AddVectoredExceptionHandler(1, on_exception);
    }
    void remove(const std::byte* begin)
    {
        const std::lock_guard lock(mutex_);
        std::erase_if(ranges_, [&](const Range& range) { return range.begin == begin; });
    }
    /// Commits the block of an address. False: it is in no range, or there is no memory.
    bool commit(std::byte* at)
    {
        const std::shared_lock lock(mutex_);
        for (const Range& range : ranges_) {
            if (at < range.begin || at >= range.begin + range.size) continue;
            const std::size_t first = std::size_t(at - range.begin) / block * block;
            return VirtualAlloc(range.begin + first, std::min(block, range.size - first), MEM_COMMIT, PAGE_READWRITE);
        }
        return false;
    }

private:
    static LONG CALLBACK on_exception(EXCEPTION_POINTERS* about);

    SharedMutex mutex_;
    std::vector<Range> ranges_;
    void* handler_ = nullptr;
};

/// Never destroyed: memory may be touched while static objects end.
Ranges& ranges()
{
    static Ranges& all = *new Ranges;
    return all;
}

LONG CALLBACK Ranges::on_exception(EXCEPTION_POINTERS* about)
{
    const EXCEPTION_RECORD& record = *about->ExceptionRecord;
    if (record.ExceptionCode != EXCEPTION_ACCESS_VIOLATION || record.NumberParameters < 2)
        return EXCEPTION_CONTINUE_SEARCH;
    const bool committed = ranges().commit(reinterpret_cast<std::byte*>(record.ExceptionInformation[1]));
    return committed ? EXCEPTION_CONTINUE_EXECUTION : EXCEPTION_CONTINUE_SEARCH;
}

} // namespace

LazyMemory::LazyMemory(std::size_t bytes) : size_(std::max<std::size_t>((bytes + page - 1) / page * page, page))
{
    bytes_ = static_cast<std::byte*>(VirtualAlloc(nullptr, size_, MEM_RESERVE, PAGE_READWRITE));
    if (!bytes_) throw std::bad_alloc();
    ranges().add({bytes_, size_});
}

LazyMemory::~LazyMemory()
{
    if (!bytes_) return;
    ranges().remove(bytes_);
    VirtualFree(bytes_, 0, MEM_RELEASE);
}

void LazyMemory::give_back(std::size_t begin, std::size_t size)
{
    ONCOLLIDE_ASSERT(begin % page == 0 && begin < size_);
    VirtualFree(bytes_ + begin, std::min((size + page - 1) / page * page, size_ - begin), MEM_DECOMMIT);
}

} // namespace oncollide
