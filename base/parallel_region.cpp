// The only OpenMP construct of the program, alone in its file: the thread sanitizer cannot see inside the OpenMP
// runtime, so this file is compiled without it and parallel.cpp orders memory by atomics that it can see.
namespace oncollide {

void parallel_region(int threads, void (*serve)(void* job, int thread), void* job);

void parallel_region(int threads, void (*serve)(void* job, int thread), void* job)
{
#pragma omp parallel for num_threads(threads) schedule(static, 1)
    for (int thread = 0; thread < threads; ++thread) serve(job, thread);
}

} // namespace oncollide
