#pragma once
#include <string>

#include <oncollide/base/files/output_file.hpp>

#include "study/pictures.hpp"
#include "study/study.hpp"

// The formats of a study: a table, CSV, JSON, and a page with figures.
namespace oncollide::tools {

void print_study(const Study& study);
/// One row per variant, then one per peer.
void write_study_csv(OutputFile& file, const Study& study);
void write_study_json(OutputFile& file, const Study& study, const std::string& program);

/// The row's needed share of the full trees, "3.1 %"; "-" if unknown.
std::string needed_text(const StudyRow& row);
/// Speed relative to FCL, "2.50"; "-" without FCL.
std::string ratio_text(const Study& study, const std::vector<double>& ms);
/// Certified bound: "0.0123", "0" if the exact level decided all pairs.
std::string error_text(const StudyRow& row);
/// The q-quantile of the false positives' true distances, m; q from 0 to 1. 0 if there are none.
double false_positive_quantile(const StudyRow& row, double q);

/// Writes a self-contained HTML page: no network, scripts or fonts; pictures embedded. Well-formed as XML, too.
/// @param about  settings and program, lines of plain text
/// @param command  that made the study, as typed; empty: unknown
void write_study_page(OutputFile& file, const Study& study, const StudyPictures& pictures, const std::string& command,
                      const std::string& about);

// The figures of the page, as inline SVG. No information is shown by colour alone.
/// Time per frame against certified error, one line per series; exact results and peers at the left edge.
void draw_speed_error(OutputFile& file, const Study& study);
/// Time of each stage, one row per variant.
void draw_stage_times(OutputFile& file, const Study& study);
/// Pairs that enter and leave the stages, one row per variant.
void draw_funnel(OutputFile& file, const Study& study);
/// True distances of the false positives, in tenths of their bound, one row per variant.
void draw_false_positives(OutputFile& file, const Study& study);

} // namespace oncollide::tools
