#include <oncollide/runs/pair_list.hpp>

namespace oncollide {

void PairList::add(const PairResult& pair, std::uint64_t frame)
{
    if (full() || !seen_.insert(std::uint64_t{index(pair.a)} << 32 | index(pair.b)).second) return;
    if (first_.size() < most_shown) first_.push_back({pair, frame});
}

} // namespace oncollide
