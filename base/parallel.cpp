#include <oncollide/base/parallel.hpp>

#include <algorithm>
#include <atomic>

#include <omp.h>

namespace oncollide {

int hardware_threads()
{
    return std::max(1, omp_get_num_procs());
}

namespace {

// Chunks are dealt by an atomic counter. Memory is ordered by atomics too, so that the hand-over is visible to tools
// that do not know OpenMP's barriers: the gate publishes the job to its threads, `left` their work to the caller.
std::atomic<unsigned> gate{0};

struct Job {
    std::atomic<std::size_t> next{0};
    std::atomic<int> left{0};
    std::size_t count, grain;
    FunctionRef<void(std::size_t, std::size_t, int)> work;

    void serve(int thread)
    {
        for (;;) {
            const std::size_t begin = next.fetch_add(grain, std::memory_order_acq_rel);
            if (begin >= count) break;
            work(begin, std::min(count, begin + grain), thread);
        }
        left.fetch_add(1, std::memory_order_acq_rel);
    }
};

} // namespace

void parallel_region(int threads, void (*serve)(void* job, int thread), void* job); // parallel_region.cpp

void parallel_chunks(std::size_t count, std::size_t grain, int threads,
                     FunctionRef<void(std::size_t, std::size_t, int)> work)
{
    if (count == 0) return;
    grain = std::max<std::size_t>(grain, 1);
    const auto chunks = static_cast<int>(std::min<std::size_t>((count + grain - 1) / grain, 1u << 20));
    threads = std::min(threads, chunks);
    if (threads <= 1) {
        work(0, count, 0);
        return;
    }
    Job job{.count = count, .grain = grain, .work = work};
    gate.fetch_add(1, std::memory_order_acq_rel);
    parallel_region(
        threads,
        [](void* j, int thread) {
            gate.load(std::memory_order_acquire);
            static_cast<Job*>(j)->serve(thread);
        },
        &job);
    job.left.load(std::memory_order_acquire);
}

} // namespace oncollide
