#pragma once
#include <span>

#include <oncollide/scenes/scene.hpp>

#include "study/study.hpp"
#include "study/truth.hpp"

namespace oncollide::tools {

/// Holds a variant's answer to the truth's frame against it.
void judge(StudyRow& row, std::span<const PairResult> answer, StudyTruth& truth, int frame);
/// The same of a peer's. @param colliding  sorted  @param number  of the frame, in words
void judge(StudyPeer& peer, std::span<const BodyPair> colliding, StudyTruth& truth, const Scene& scene, int number);

} // namespace oncollide::tools
