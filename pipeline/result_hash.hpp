#pragma once
#include <bit>
#include <cstdint>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/pipeline/settings.hpp>

namespace oncollide {

inline void mix(std::uint64_t& hash, std::uint64_t value)
{
    hash = splitmix(hash ^ value);
}

/// Adds a pair to a frame's hash, which starts at 0 and depends on the order of pairs. Separate pairs are ignored.
inline void mix(std::uint64_t& hash, const PairResult& pair, bool with_kinds)
{
    if (pair.verdict == Verdict::separate) return;
    mix(hash, static_cast<std::uint64_t>(pair.a.slot) << 32 | pair.b.slot);
    mix(hash, static_cast<std::uint64_t>(pair.verdict) << 8 | static_cast<std::uint64_t>(pair.stage));
    if (with_kinds) mix(hash, static_cast<std::uint64_t>(pair.kind));
    mix(hash, std::bit_cast<std::uint64_t>(pair.bound));
}

/// The times of a sweep.
struct SweepTimes {
    double clear_until, contact_by;
};

/// Adds the times of the pair that was added last, unless it is separate.
inline void mix(std::uint64_t& hash, const PairResult& pair, const SweepTimes& times)
{
    if (pair.verdict == Verdict::separate) return;
    mix(hash, std::bit_cast<std::uint64_t>(times.clear_until));
    mix(hash, std::bit_cast<std::uint64_t>(times.contact_by));
}

/// Hash of the settings that affect results.
std::uint64_t hash_of(const Settings& settings);

} // namespace oncollide
