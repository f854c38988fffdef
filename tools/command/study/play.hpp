#pragma once
#include <span>

#include "study/peers.hpp"
#include "study/study.hpp"
#include "study/workload.hpp"
#include "truth/scene_truth.hpp"

namespace oncollide::tools {

/// The median diagonal of the bodies' boxes, m.
double median_size(const Scene& scene);

/// How a study is played.
struct PlayOptions {
    int warm_up = 0, repeats = 1;
    std::size_t bounds = 0; ///< number of certified bounds to check per frame and variant, besides false positives
    bool any_peer = false;  ///< also peers that do not support the request: only their times and collisions count
    bool needed = true;     ///< also count_needed()
};

/// Plays the workload with all variants and all supported `peers`, alternating frame by frame, `repeats` times. A scene
/// starts anew each time; poses keep the trees of the run before. Results are judged in the first run; the least time
/// of each frame counts. Shows progress.
/// @param variants  all with the same clearance and mode
Study play_study(StudyWorkload& workload, const std::vector<StudyVariant>& variants, std::vector<PeerKind> peers,
                 const PlayOptions& options);

// Parts of play_study().

/// Compares a variant's result with the truth of the current frame.
void judge(StudyRow& row, std::span<const PairResult> answer, SceneTruth& truth, const Scene& scene, int frame,
           std::size_t bounds = 0);
/// The same for a peer. @param colliding  sorted  @param number  the frame's number in messages
void judge(StudyPeer& peer, std::span<const BodyPair> colliding, SceneTruth& truth, const Scene& scene, int number);

/// Fills in each row's needed nodes: cells of sphere-trees and nodes of OBB trees that ever existed, and their number
/// in trees of all geometries that are fully grown to the same depth. If cells were dropped, the workload is played
/// again without dropping.
void count_needed(StudyWorkload& workload, Study& study);

} // namespace oncollide::tools
