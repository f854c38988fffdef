#pragma once
#include <string>
#include <vector>

#include "study/study.hpp"
#include "study/workload.hpp"

namespace oncollide::tools {

struct StudyPicture {
    std::string caption, png; ///< the bytes of the file
};

struct StudyPictures {
    std::vector<StudyPicture> all;
    std::string none; ///< why there are none; empty when there could be some
};

/// Pairs that were missed, and the worst false positives of each series at its widest and its narrowest error: both
/// bodies from afar, and the place where they are nearest. Each is found by playing the workload again up to its frame.
/// Without a renderer there are none.
StudyPictures draw_study_pictures(StudyWorkload& workload, const Study& study);

} // namespace oncollide::tools
