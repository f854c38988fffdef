#pragma once
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <oncollide/base/text_sink.hpp>

namespace oncollide::tools {

/// A list of a report in JSON.
struct JsonList {
    std::string name;
    std::size_t count;
    std::function<nlohmann::ordered_json(std::size_t)> at;
};

/// Writes the members of `head` on one line, then the lists with one line per element.
void write_report_lines(TextSink& out, const nlohmann::ordered_json& head, const std::vector<JsonList>& lists);

/// The text of a value. Bytes that are not UTF-8 become U+FFFD.
std::string json_text(const nlohmann::ordered_json& value);

} // namespace oncollide::tools
