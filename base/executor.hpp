#pragma once
#include <functional>

namespace oncollide {

/// Runs the tasks of parallel loops. The library brings two; an application with threads of its own derives a third and
/// puts it into Settings::executor. It must outlive what uses it. Results do not depend on it.
class Executor {
public:
    virtual ~Executor() = default;

    /// How many tasks can run at the same time, the caller's included; >= 1. This is what `threads = 0` stands for.
    virtual int threads() const = 0;

    /// Calls work(task) once for each task in [0, tasks), and returns when all calls have returned. Tasks never wait
    /// for each other: they may run on any threads, in any order, at the same time or one after the other. `work` does
    /// not throw, and never calls run(). Several threads may call run() at the same time.
    virtual void run(int tasks, const std::function<void(int task)>& work) = 0;
};

/// The default: threads of the library's own, which sleep while there is nothing to do. They start when they are first
/// needed and last as long as the process; a process made by fork() gets threads of its own.
Executor& thread_pool();

/// OpenMP's threads, for applications that use OpenMP beside the library. GNU's runtime makes its threads wait actively
/// unless OMP_WAIT_POLICY=passive was in the environment when the process started, which costs milliseconds for each
/// loop where other programs want the same cores; and it does not survive fork().
/// Throws Error{usage} in builds without it (ONCOLLIDE_OPENMP=OFF).
Executor& openmp_executor();

} // namespace oncollide
