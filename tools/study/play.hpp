#pragma once
#include "study/peers.hpp"
#include "study/study.hpp"
#include "study/workload.hpp"

namespace oncollide::tools {

/// Plays the workload with all variants and those of `peers` that can, turn about, `repeats` times: a scene from
/// nothing, poses with the trees of the run before. Answers are judged in the first run; of a frame's times the least
/// counts. Shows progress.
/// @param variants  of one clearance and mode
Study play_study(StudyWorkload& workload, const std::vector<StudyVariant>& variants, std::vector<PeerKind> peers,
                 int warm_up, int repeats);

} // namespace oncollide::tools
