#pragma once
#include <string>
#include <string_view>

#include <oncollide/base/files/output_file.hpp>

// Parts of pages that hold text, tables and pictures: self-contained, well-formed as XML.
namespace oncollide::tools {

struct PagePicture {
    std::string caption, png; ///< the bytes of the file
};

/// @param command  the command that made the page, as typed; empty: unknown
void begin_page(OutputFile& file, const std::string& title, const std::string& command);
void heading(OutputFile& file, std::string_view words);
void paragraph(OutputFile& file, std::string_view words);
void fault(OutputFile& file, std::string_view words);
void show_picture(OutputFile& file, const PagePicture& picture);
/// Advice for the name of a figure's file.
constexpr std::string_view svg_to_pdf = "; rsvg-convert (Debian: librsvg2-bin) makes PDF from it";

/// @param about  settings and program, lines of plain text
void end_page(OutputFile& file, const std::string& about);

} // namespace oncollide::tools
