#pragma once
#include <functional>

#include <oncollide/base/error.hpp>

namespace oncollide {

/// Runs the tasks of parallel loops. The library has two executors; an application with its own threads can derive
/// another one and pass it as Settings::executor. It must outlive all its users. Results do not depend on it.
class ONCOLLIDE_API Executor {
public:
    virtual ~Executor() = default;

    /// The number of tasks that can run at the same time, the caller's included; >= 1. `threads = 0` selects this
    /// number.
    virtual int threads() const = 0;

    /// Calls work(task) once for each task in [0, tasks), and returns when all calls have returned. Tasks never wait
    /// for each other, so they may run on any threads, in any order, in parallel or in sequence. `work` does not throw
    /// and never calls run(). Several threads may call run() at the same time.
    virtual void run(int tasks, const std::function<void(int task)>& work) = 0;
};

/// The default: the library's own threads, which sleep while idle. They start at first use and last as long as the
/// process; after fork(), the child starts its own.
ONCOLLIDE_API Executor& thread_pool();

/// OpenMP's threads, for applications that also use OpenMP. GNU's runtime spins while waiting, unless the environment
/// variable OMP_WAIT_POLICY=passive was set when the process started; spinning costs milliseconds per loop when other
/// programs need the same cores. GNU's runtime does not survive fork().
/// Throws Error{usage} in builds without OpenMP (ONCOLLIDE_OPENMP=OFF).
ONCOLLIDE_API Executor& openmp_executor();

} // namespace oncollide
