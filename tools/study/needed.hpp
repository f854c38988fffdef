#pragma once
#include "study/study.hpp"
#include "study/workload.hpp"

namespace oncollide::tools {

/// Fills in what each row's trees needed, of what they could hold: cells of sphere-trees and nodes of oriented boxes
/// that ever were, over all that there are when every geometry's tree is grown everywhere to the same depth.
/// Where cells were dropped, the workload is played again without dropping.
void count_needed(StudyWorkload& workload, Study& study);

} // namespace oncollide::tools
