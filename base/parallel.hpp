#pragma once
#include <cstddef>

#include <oncollide/base/executor.hpp>
#include <oncollide/base/function_ref.hpp>

namespace oncollide {

/// Calls work(begin, end, thread) for chunks of at most `grain` items that cover [0, count) once, as up to `threads`
/// tasks of current_executor(); `thread`, in [0, threads), is that of one call at a time. Which thread gets which chunk
/// is not fixed: results must be joined by item. With one thread or one chunk, and inside another such loop, it is a
/// plain call. What `work` throws, for want of memory, ends the loop, which throws it on.
void parallel_chunks(std::size_t count, std::size_t grain, int threads,
                     FunctionRef<void(std::size_t begin, std::size_t end, int thread)> work);

/// Within its life, the parallel loops that this thread starts run on `executor`; with null nothing changes. Scopes
/// nest.
class ExecutorScope {
public:
    explicit ExecutorScope(Executor* executor);
    ~ExecutorScope();
    ExecutorScope(const ExecutorScope&) = delete;
    ExecutorScope& operator=(const ExecutorScope&) = delete;

private:
    Executor* outer_;
};

/// The executor of this thread's innermost scope, else thread_pool().
Executor& current_executor();

/// The number of hardware threads that this process may use; >= 1.
int hardware_threads();

} // namespace oncollide
