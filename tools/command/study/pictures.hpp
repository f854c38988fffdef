#pragma once
#include <string>
#include <vector>

#include "common/page_parts.hpp"
#include "render/painter_process.hpp"
#include "study/study.hpp"
#include "study/workload.hpp"

namespace oncollide::tools {

struct StudyPictures {
    std::vector<PagePicture> all;
    std::string missing; ///< "No pictures: ..." or "Not all pictures: ..." with the reason; empty: none is missing
};

/// Draws missed pairs, and the worst false positives of each series at its largest and its smallest error: both bodies
/// from afar, and their nearest points. The workload is played again up to each frame.
StudyPictures draw_study_pictures(StudyWorkload& workload, const Study& study, PainterProcess& painter);

} // namespace oncollide::tools
