#pragma once
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <oncollide/base/text/csv_writer.hpp>
#include <oncollide/base/text/json_writer.hpp>

namespace oncollide::tools {

/// A value of a benchmark and its name, which ends with its unit: "first_ms" has the title "first, ms" on the console.
struct Figure {
    using Value = std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string, Hex, Digits>;

    Figure(std::string_view n, bool v) : name(n), value(v) {}
    Figure(std::string_view n, std::signed_integral auto v) : name(n), value(std::int64_t(v)) {}
    Figure(std::string_view n, std::unsigned_integral auto v) : name(n), value(std::uint64_t(v)) {}
    Figure(std::string_view n, double v) : name(n), value(v) {}
    Figure(std::string_view n, std::optional<double> v) : name(n) // none: an empty cell
    {
        if (v) value = *v;
    }
    Figure(std::string_view n, const std::string& v) : name(n), value(v) {}
    Figure(std::string_view n, std::string_view v) : name(n), value(std::string(v)) {}
    Figure(std::string_view n, const char* v) : name(n), value(std::string(v)) {}
    Figure(std::string_view n, Hex v) : name(n), value(v) {}
    Figure(std::string_view n, Digits v) : name(n), value(v) {} ///< in files with more or fewer digits than six

    std::string name;
    Value value;
};
using Figures = std::vector<Figure>;

/// Names and values in turn.
template <class... NamesAndValues>
Figures figures(const NamesAndValues&... parts)
{
    Figures all;
    const auto add = [&](auto& self, std::string_view name, const auto& value, const auto&... more) {
        all.emplace_back(name, value);
        if constexpr (sizeof...(more) > 0) self(self, more...);
    };
    add(add, parts...);
    return all;
}

/// A table of results: lines on the console while they come in, rows of a CSV file, objects in JSON. All rows of a
/// table have the same names.
class ResultTable {
public:
    /// @param csv     file; empty: none
    /// @param widths  of the columns of texts on the console, in order
    /// @param line    first line of the file, with its line break
    explicit ResultTable(const std::string& csv = {}, std::vector<int> widths = {}, std::string_view line = {});

    /// Sets figures that are equal in the next rows: files have them first, the console leaves them out.
    void about(Figures figures) { about_ = std::move(figures); }
    /// @param shown  on the console and in the files
    /// @param filed  only in the files, after the others
    void row(const Figures& shown, const Figures& filed = {});
    /// A line on the console alone, such as a sum, with the names of the other rows.
    void print(const Figures& shown);
    /// Prints a blank line and `title`, and the names again before the next row.
    void section(const std::string& title);
    /// Completes the CSV file.
    void commit();
    /// Writes all rows as an array of objects.
    void write(JsonWriter& json, int indent) const;
    bool empty() const { return rows_.empty(); }

private:
    void print_names(const Figures& shown);

    std::vector<int> text_widths_, widths_; ///< widths_: by column; negative: left-aligned
    std::optional<OutputFile> file_;
    std::optional<CsvWriter> csv_;
    Figures about_;
    std::vector<Figures> rows_;
};

/// The value of a number; 0 of anything else.
double number_of(const Figure& figure);

/// "first, ms" of "first_ms".
std::string title_of(std::string_view name);

} // namespace oncollide::tools
