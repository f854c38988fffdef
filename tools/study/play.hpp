#pragma once
#include <span>

#include "study/peers.hpp"
#include "study/study.hpp"
#include "study/truth.hpp"
#include "study/workload.hpp"

namespace oncollide::tools {

/// Plays the workload with all variants and those of `peers` that can, turn about, `repeats` times: a scene from
/// nothing, poses with the trees of the run before. Answers are judged in the first run; of a frame's times the least
/// counts. Shows progress.
/// @param variants  of one clearance and mode
Study play_study(StudyWorkload& workload, const std::vector<StudyVariant>& variants, std::vector<PeerKind> peers,
                 int warm_up, int repeats);

// The parts of it.

/// Holds a variant's answer to the truth's frame against it.
void judge(StudyRow& row, std::span<const PairResult> answer, StudyTruth& truth, int frame);
/// The same of a peer's. @param colliding  sorted  @param number  of the frame, in words
void judge(StudyPeer& peer, std::span<const BodyPair> colliding, StudyTruth& truth, const Scene& scene, int number);

/// Fills in what each row's trees needed, of what they could hold: cells of sphere-trees and nodes of oriented boxes
/// that ever were, over all that there are when every geometry's tree is grown everywhere to the same depth.
/// Where cells were dropped, the workload is played again without dropping.
void count_needed(StudyWorkload& workload, Study& study);

} // namespace oncollide::tools
