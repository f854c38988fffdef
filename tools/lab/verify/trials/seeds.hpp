#pragma once
#include <algorithm>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <oncollide/base/threads/parallel.hpp>

#include "truth/tally.hpp"

namespace oncollide::tools {

/// The first fault of a trial.
struct FirstFault {
    std::uint64_t seed = 0;
    std::string what{}; ///< empty: none

    void take(std::uint64_t of, std::string fault)
    {
        if (what.empty() && !fault.empty()) seed = of, what = std::move(fault);
    }
    /// The seeds of `o` are the later ones.
    void operator+=(const FirstFault& o) { take(o.seed, o.what); }
};

/// Calls run(seed, sum) for `count` seeds from `first` on, in parallel, and adds all sums in the order of the seeds:
/// the result does not depend on the number of threads. Calls done() once per seed, never concurrently.
/// @param grain  seeds in a task, at least
template <class Sum>
Sum sum_of_seeds(
    std::uint64_t first, std::uint64_t count, int threads, auto run, const std::function<void()>& done = [] {},
    std::size_t grain = 16)
{
    grain = std::max(grain, std::size_t(count >> 16)); // bounds the memory
    std::vector<Sum> sums((count + grain - 1) / grain);
    std::mutex guard;
    parallel_chunks(count, grain, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t k = begin; k < end; ++k) {
            run(first + k, sums[k / grain]);
            const std::lock_guard lock(guard);
            done();
        }
    });
    Sum all{};
    for (const Sum& sum : sums) all += sum;
    return all;
}

/// The sum of run(number, tally) for all numbers below `count`.
inline Tally try_many(const std::string& family, std::uint64_t count, int threads, auto run, std::size_t grain = 16)
{
    Tally sum = sum_of_seeds<Tally>(
        0, count, threads, run, [] {}, grain);
    sum.family = family;
    return sum;
}

} // namespace oncollide::tools
