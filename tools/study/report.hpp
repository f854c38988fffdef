#pragma once
#include <string>

#include <oncollide/base/output_file.hpp>

#include "study/study.hpp"

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

} // namespace oncollide::tools
