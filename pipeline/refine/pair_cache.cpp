#include <oncollide/pipeline/refine/pair_cache.hpp>

namespace oncollide {

void PairCache::begin_frame(std::span<const BodyPair> pairs, std::span<const std::uint8_t> fresh)
{
    now_.swap(before_);
    now_.resize(pairs.size());
    auto last = before_.begin();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const BodyPair pair = pairs[i];
        while (last != before_.end() && last->pair < pair) ++last;
        if (last != before_.end() && last->pair == pair && !fresh[pair.a] && !fresh[pair.b])
            now_[i] = *last;
        else
            now_[i] = {.pair = pair};
    }
}

} // namespace oncollide
