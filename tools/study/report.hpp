#pragma once
#include <string>

#include <oncollide/base/output_file.hpp>

#include "study/pictures.hpp"
#include "study/study.hpp"

// What a study is written as: a table, CSV, JSON, and a page with figures.
namespace oncollide::tools {

void print_study(const Study& study);
/// One row a variant; those of peers last.
void write_study_csv(OutputFile& file, const Study& study);
void write_study_json(OutputFile& file, const Study& study, const std::string& program);

/// The share of the model that the row's trees needed, "3.1 %"; "-" when unknown.
std::string needed_text(const StudyRow& row);
/// How many times as fast as FCL, "2.50"; "-" without it.
std::string ratio_text(const Study& study, const std::vector<double>& ms);
/// Certified bound: "0.0123", "0" where the exact level decided all.
std::string error_text(const StudyRow& row);
/// Of the false positives' true distances, m; q from 0 to 1. 0 when there are none.
double false_positive_quantile(const StudyRow& row, double q);

/// One HTML page that needs nothing else: no network, no scripts, no fonts, pictures inside. Well-formed as XML too.
/// @param about  settings and program, lines of plain text
void write_study_page(OutputFile& file, const Study& study, const StudyPictures& pictures, const std::string& about);

// The figures of the page, as inline SVG. Nothing in them is told by colour alone.
/// Time a frame against certified error, a line a series; exact answers and peers at the left edge.
void draw_speed_error(OutputFile& file, const Study& study);
/// Time of each stage, a row a variant.
void draw_stage_times(OutputFile& file, const Study& study);
/// Pairs that enter and leave the stages, a row a variant.
void draw_funnel(OutputFile& file, const Study& study);
/// True distances of the false positives, in tenths of their bound, a row a variant.
void draw_false_positives(OutputFile& file, const Study& study);

} // namespace oncollide::tools
