#pragma once
#include <string>

#include <oncollide/base/output_file.hpp>

#include "study/pictures.hpp"
#include "study/study.hpp"

namespace oncollide::tools {

/// One HTML page that needs nothing else: no network, no scripts, no fonts, pictures inside. Well-formed as XML too.
/// @param about  settings and program, lines of plain text
void write_study_page(OutputFile& file, const Study& study, const StudyPictures& pictures, const std::string& about);

} // namespace oncollide::tools
