#pragma once
#include <cstddef>

#include <oncollide/base/executor.hpp>
#include <oncollide/base/function_ref.hpp>

namespace oncollide {

/// Calls work(begin, end, thread) for chunks of at most `grain` items that cover [0, count) once, in up to `threads`
/// tasks of current_executor(). No two concurrent calls have the same `thread`, which is in [0, threads). Chunks go to
/// threads in no fixed order, so results must be joined by item. With one thread or one chunk, and inside another
/// parallel loop, `work` is called once for all items. An exception from `work` ends the loop and is rethrown.
void parallel_chunks(std::size_t count, std::size_t grain, int threads,
                     FunctionRef<void(std::size_t begin, std::size_t end, int thread)> work);

/// While it lives, parallel loops started by this thread run on `executor`; null changes nothing. Scopes nest.
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

/// The number of threads that a caller requests, or hardware_threads() for 0.
inline int threads_of(int requested)
{
    return requested ? requested : hardware_threads();
}

} // namespace oncollide
