// The only file that uses OpenMP.
#include <algorithm>

#include <omp.h>

#include <oncollide/base/executor.hpp>

namespace oncollide {

namespace {

class OpenMpExecutor final : public Executor {
public:
    int threads() const override { return std::max(1, omp_get_max_threads()); }
    void run(int tasks, const std::function<void(int)>& work) override
    {
#pragma omp parallel for num_threads(tasks) schedule(static, 1)
        for (int task = 0; task < tasks; ++task) work(task);
    }
};

} // namespace

Executor& openmp_executor()
{
    static OpenMpExecutor executor;
    return executor;
}

} // namespace oncollide
