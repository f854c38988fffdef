#pragma once
#include <oncollide/base/output_file.hpp>

#include "study/study.hpp"

// The drawings of a study, as inline SVG. Nothing in them is told by colour alone.
namespace oncollide::tools {

/// Time a frame against certified error, a line a series; exact answers and peers at the left edge.
void draw_speed_error(OutputFile& file, const Study& study);
/// Time of each stage, a row a variant.
void draw_stage_times(OutputFile& file, const Study& study);
/// Pairs that enter and leave the stages, a row a variant.
void draw_funnel(OutputFile& file, const Study& study);
/// True distances of the false positives, in tenths of their bound, a row a variant.
void draw_false_positives(OutputFile& file, const Study& study);

} // namespace oncollide::tools
