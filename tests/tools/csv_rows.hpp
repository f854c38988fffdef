#pragma once
#include <algorithm>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace oncollide::test {

/// The cells of a CSV line; commas are allowed in quotes only.
inline std::vector<std::string> csv_cells(const std::string& line)
{
    std::vector<std::string> result(1);
    bool quoted = false;
    for (char c : line) {
        if (c == '"')
            quoted = !quoted;
        else if (c == ',' && !quoted)
            result.emplace_back();
        else
            result.back() += c;
    }
    return result;
}

/// Rows of a CSV file as maps by column.
inline std::vector<std::map<std::string, std::string>> read_csv(const std::string& text)
{
    std::istringstream lines(text);
    std::string line;
    std::getline(lines, line);
    const std::vector<std::string> names = csv_cells(line);
    std::vector<std::map<std::string, std::string>> rows;
    while (std::getline(lines, line)) {
        const std::vector<std::string> values = csv_cells(line);
        EXPECT_EQ(values.size(), names.size()) << line;
        rows.emplace_back();
        for (std::size_t k = 0; k < std::min(names.size(), values.size()); ++k) rows.back()[names[k]] = values[k];
    }
    return rows;
}

} // namespace oncollide::test
