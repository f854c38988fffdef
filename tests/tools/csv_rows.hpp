#pragma once
#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <oncollide/base/text/csv_reader.hpp>

namespace oncollide::test {

/// Rows of a CSV file as maps by column.
inline std::vector<std::map<std::string, std::string>> read_csv(const std::string& text)
{
    const std::string file = "csv";
    std::vector<std::string> names;
    std::vector<std::map<std::string, std::string>> rows;
    for (CsvReader csv(file, text, CsvReader::Style::list); !csv.at_end(); csv.next_line()) {
        std::vector<std::string> values;
        for (bool last = false; !last;) values.emplace_back(csv.next(last));
        if (names.empty()) {
            names = values;
            continue;
        }
        EXPECT_EQ(values.size(), names.size()) << "line " << csv.line();
        rows.emplace_back();
        for (std::size_t k = 0; k < std::min(names.size(), values.size()); ++k) rows.back()[names[k]] = values[k];
    }
    return rows;
}

} // namespace oncollide::test
