#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <system_error>
#include <thread>

#include <oncollide/base/threads/lock_order.hpp>
#include <oncollide/base/threads/parallel.hpp>

#if defined(__linux__)
#include <sched.h>
#endif
#if __has_include(<pthread.h>) && !defined(_WIN32)
#include <pthread.h>
#endif

namespace oncollide {

int hardware_threads()
{
#if defined(__linux__)
    cpu_set_t allowed;
    if (sched_getaffinity(0, sizeof allowed, &allowed) == 0) return std::max(1, CPU_COUNT(&allowed));
#endif
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

namespace {

inline void pause()
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    asm volatile("yield");
#endif
}

constexpr auto spin_time = std::chrono::microseconds(30);

/// Spins about as long as waking a sleeping thread takes, and no longer, because other processes may need the core.
template <class Ready>
bool spin_until(const Ready& ready)
{
    const auto end = std::chrono::steady_clock::now() + spin_time;
    do {
        for (int i = 0; i < 16; ++i) {
            if (ready()) return true;
            pause();
        }
    } while (std::chrono::steady_clock::now() < end);
    return false;
}

/// One lock guards all tasks: there are no more tasks than threads. The caller also takes tasks, and waits only for
/// tasks that a worker has started; on a busy machine it never waits for a thread to be scheduled.
class ThreadPool final : public Executor {
public:
    int threads() const override { return spin_limit_; }

    void run(int tasks, const std::function<void(int)>& work) override
    {
        Job job{.work = work, .tasks = tasks, .unfinished{tasks}};
        int wake = 0;
        {
            std::lock_guard lock(mutex_);
            start_workers(tasks - 1);
            append(job);
            wake = std::min(sleeping_, tasks - 1);
        }
        if (wake == 1)
            opened_.notify_one();
        else if (wake > 1)
            opened_.notify_all();
        for (int task; (task = take(job)) < tasks;) finish(job, task);
        const auto done = [&] { return job.unfinished.load(std::memory_order_acquire) == 0; };
        if (done() || (may_spin() && spin_until(done))) return;
        std::unique_lock lock(mutex_);
        finished_.wait(lock, done);
    }

private:
    struct Job {
        const std::function<void(int)>& work;
        const int tasks;
        int next = 0; ///< first task not taken
        Job* later = nullptr;
        std::atomic<int> unfinished;
    };

    void append(Job& job)
    {
        Job** end = &first_;
        while (*end) end = &(*end)->later;
        *end = &job;
        any_open_.store(true, std::memory_order_relaxed);
    }

    int take_locked(Job& job)
    {
        const int task = job.next++;
        if (job.next == job.tasks) { // the last task: remove the job from the list
            Job** at = &first_;
            while (*at != &job) at = &(*at)->later;
            *at = job.later;
            any_open_.store(first_ != nullptr, std::memory_order_relaxed);
        }
        return task;
    }

    int take(Job& job)
    {
        std::lock_guard lock(mutex_);
        return job.next < job.tasks ? take_locked(job) : job.tasks;
    }

    void finish(Job& job, int task)
    {
        job.work(task);
        if (job.unfinished.fetch_sub(1, std::memory_order_acq_rel) > 1) return;
        { // after this the caller either sees that all tasks are done, or is waiting already
            std::lock_guard lock(mutex_);
        }
        finished_.notify_all();
    }

    void start_workers(int wanted)
    {
        try {
            for (; workers_ < std::min(wanted, most_workers); ++workers_) std::thread([this] { serve(); }).detach();
        } catch (const std::system_error&) {
            // The system grants no more threads: the existing ones do all tasks.
        }
        spinning_pays_.store(workers_ < spin_limit_, std::memory_order_relaxed);
    }

    bool may_spin() const { return spinning_pays_.load(std::memory_order_relaxed); }

    [[noreturn]] void serve()
    {
        for (;;) {
            if (may_spin()) spin_until([&] { return any_open_.load(std::memory_order_relaxed); });
            Job* job = nullptr;
            int task = 0;
            {
                std::unique_lock lock(mutex_);
                ++sleeping_;
                opened_.wait(lock, [&] { return first_ != nullptr; });
                --sleeping_;
                job = first_;
                task = take_locked(*job);
            }
            finish(*job, task);
        }
    }

    static constexpr int most_workers = 1023;
    const int spin_limit_ = hardware_threads();

    OrderedMutex<LockRank::pool> mutex_;
    OrderedCondition opened_, finished_;
    Job* first_ = nullptr; ///< jobs with tasks left, oldest first
    int workers_ = 0, sleeping_ = 0;
    std::atomic<bool> any_open_{false};      ///< whether first_ is set, readable without the lock
    std::atomic<bool> spinning_pays_{false}; ///< false if there are more threads than processors
};

std::atomic<ThreadPool*> pool{nullptr};

/// Never destroyed, because its threads outlive static objects.
ThreadPool& make_pool()
{
    static OrderedMutex<LockRank::pool_making> making;
    std::lock_guard lock(making);
    if (ThreadPool* there = pool.load(std::memory_order_acquire)) return *there;
#if __has_include(<pthread.h>) && !defined(_WIN32)
    // After fork() the child has the pool's memory, but not its threads.
    [[maybe_unused]] static const int at_fork =
        pthread_atfork(nullptr, nullptr, [] { pool.store(nullptr, std::memory_order_relaxed); });
#endif
    auto* made = new ThreadPool;
    pool.store(made, std::memory_order_release);
    return *made;
}

} // namespace

Executor& thread_pool()
{
    ThreadPool* there = pool.load(std::memory_order_acquire);
    return there ? *there : make_pool();
}

} // namespace oncollide
