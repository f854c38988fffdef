#include <oncollide/base/threads/parallel.hpp>

#include <algorithm>
#include <atomic>
#include <exception>
#include <functional>

namespace oncollide {
namespace {

thread_local Executor* scope_executor = nullptr;
thread_local bool inside_a_loop = false;

} // namespace

ExecutorScope::ExecutorScope(Executor* executor) : outer_(scope_executor)
{
    if (executor) scope_executor = executor;
}

ExecutorScope::~ExecutorScope()
{
    scope_executor = outer_;
}

Executor& current_executor()
{
    return scope_executor ? *scope_executor : thread_pool();
}

void parallel_chunks(std::size_t count, std::size_t grain, int threads,
                     FunctionRef<void(std::size_t, std::size_t, int)> work)
{
    if (count == 0) return;
    grain = std::max<std::size_t>(grain, 1);
    const auto chunks = static_cast<int>(std::min<std::size_t>((count + grain - 1) / grain, 1u << 20));
    threads = std::min(threads, chunks);
    if (threads <= 1 || inside_a_loop) {
        work(0, count, 0);
        return;
    }
    // Each task takes chunks until none is left, so a task that starts late or only after the others delays nothing.
    std::atomic<std::size_t> next{0};
    std::atomic<bool> failed{false};
    std::exception_ptr fault; // the first exception
    const auto take_chunks = [&](int task) noexcept {
        inside_a_loop = true;
        try {
            while (!failed.load(std::memory_order_relaxed)) {
                const std::size_t begin = next.fetch_add(grain, std::memory_order_relaxed);
                if (begin >= count) break;
                work(begin, std::min(count, begin + grain), task);
            }
        } catch (...) {
            if (!failed.exchange(true)) fault = std::current_exception();
        }
        inside_a_loop = false;
    };
    current_executor().run(threads, std::ref(take_chunks)); // a reference needs no allocation
    if (fault) std::rethrow_exception(fault);
}

} // namespace oncollide
