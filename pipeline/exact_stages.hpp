// What the two exact levels share.
#pragma once
#include <oncollide/pipeline/stage.hpp>

namespace oncollide {

/// Of the level that decides finally; in PairResult::stage.
constexpr std::uint8_t exact_stage_index = 4;

inline std::string_view off_unless_asked(const Frame& frame)
{
    return frame.settings->exact == ExactLevel::off ? "off" : std::string_view{};
}

inline void pass_on(const Frame& frame, StageStats& stats)
{
    for (const PairResult& result : frame.results) {
        stats.in += result.verdict != Verdict::separate;
        stats.undecided += result.verdict == Verdict::undecided;
    }
    stats.out = stats.in;
}

inline bool open(const PairResult& result)
{
    return result.verdict == Verdict::within || result.verdict == Verdict::undecided;
}

std::unique_ptr<Stage> make_fcl_stage(const Scene& scene, const Settings& settings, Forest& forest);
std::unique_ptr<Stage> make_predicates_stage(const Scene& scene, const Settings& settings, Forest& forest);

} // namespace oncollide
