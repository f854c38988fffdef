#include "common/page_parts.hpp"

#include <algorithm>

#include <oncollide/base/text/svg.hpp>

#include "common/base64.hpp"

namespace oncollide::tools {
namespace {

constexpr std::string_view style = R"(
body { font: 15px/1.5 "DejaVu Sans", Verdana, Helvetica, Arial, sans-serif; color: #222; background: #fff;
       max-width: 1000px; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.6em; } h2 { font-size: 1.2em; margin-top: 2em; }
table { border-collapse: collapse; font-size: 12px; margin: 1em 0; } th, td { padding: 3px 6px; text-align: right; }
td { border-bottom: 1px solid #ddd; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; } thead th { border-bottom: 2px solid #444; vertical-align: bottom; }
.scroll { overflow-x: auto; } .fault { font-weight: bold; border: 2px solid #222; padding: 4px 8px; }
svg { max-width: 100%; height: auto; } img { max-width: 100%; border: 1px solid #bbb; }
figure { margin: 1em 0; } figcaption { font-size: 13px; } pre { font-size: 11px; white-space: pre-wrap; }
.bar { fill: #0072b2; } .band { fill: #f4f4f4; } .head { font-weight: bold; } .name { font-size: 11px; }
.number { font-size: 11px; }
@media print { body { margin: 0; max-width: none; font-size: 10pt; } .scroll { overflow: visible; }
  table { font-size: 6pt; } th, td { padding: 1px 2px; } h2 { break-after: avoid; } figure, svg, tr { break-inside: avoid; }
  .bar { fill: #555; } }
)";

} // namespace

void begin_page(OutputFile& file, const std::string& title, const std::string& command)
{
    file.print("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><title>{0}</title>\n"
               "<style>{1}</style></head>\n<body>\n<h1>{0}</h1>\n",
               xml_escaped(title), style);
    if (!command.empty()) file.print("<pre>{}</pre>\n", xml_escaped(command));
}

void heading(OutputFile& file, std::string_view words)
{
    file.print("<h2>{}</h2>\n", xml_escaped(words));
}

void paragraph(OutputFile& file, std::string_view words)
{
    file.print("<p>{}</p>\n", xml_escaped(words));
}

void fault(OutputFile& file, std::string_view words)
{
    file.print("<p class=\"fault\">{}</p>\n", xml_escaped(words));
}

void show_picture(OutputFile& file, const PagePicture& picture)
{
    file.print("<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"/><figcaption>{0}</figcaption></figure>\n",
               xml_escaped(picture.caption), base64(picture.png));
}

void end_page(OutputFile& file, const std::string& about)
{
    heading(file, "Measurement");
    file.print("<pre>");
    for (std::size_t at = 0; at < about.size();) {
        const std::size_t end = std::min(about.find('\n', at), about.size());
        file.print("{}\n", xml_escaped(about.substr(at, end - at)));
        at = end + 1;
    }
    file.print("</pre>\n</body></html>\n");
}

} // namespace oncollide::tools
