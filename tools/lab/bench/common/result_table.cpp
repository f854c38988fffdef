#include "bench/common/result_table.hpp"

#include <algorithm>

#include <fmt/ranges.h>

#include "common/text.hpp"

namespace oncollide::tools {
namespace {

constexpr int least_text = 12, least_number = 10, number_digits = 4, file_digits = 6;

/// Calls the first of the functions that takes the value.
template <class... Functions>
struct OneOf : Functions... {
    using Functions::operator()...;
};

std::string shown_text(const Figure::Value& value)
{
    return std::visit(
        OneOf{[](std::monostate) { return std::string("-"); }, [](bool b) { return std::string(b ? "yes" : "NO"); },
              [](std::int64_t n) { return n < 0 ? fmt::format("{}", n) : grouped(std::uint64_t(n)); },
              [](std::uint64_t n) { return grouped(n); }, [](double x) { return plain_measure(x, number_digits); },
              [](const std::string& text) { return printable(text); },
              [](Hex x) { return fmt::format("{:016x}", x.value); },
              [](Digits x) { return plain_measure(x.value, x.digits); }},
        value);
}

bool is_text(const Figure& figure)
{
    return std::holds_alternative<std::string>(figure.value);
}

} // namespace

double number_of(const Figure& figure)
{
    return std::visit(OneOf{[](double x) { return x; }, [](std::int64_t n) { return double(n); },
                            [](std::uint64_t n) { return double(n); }, [](const auto&) { return 0.0; }},
                      figure.value);
}

std::string title_of(std::string_view name)
{
    std::string title(name);
    if (const std::size_t end = title.rfind('_'); end != std::string::npos && !title.substr(0, end).ends_with("_per"))
        for (const std::string_view unit : {"ns", "us", "ms", "s", "m", "mb"})
            if (title.substr(end + 1) == unit)
                title = fmt::format("{}, {}", title.substr(0, end), unit == "mb" ? "MB" : unit);
    std::ranges::replace(title, '_', ' ');
    return title;
}

ResultTable::ResultTable(const std::string& csv, std::vector<int> widths, std::string_view line)
    : text_widths_(std::move(widths))
{
    if (csv.empty()) return;
    file_.emplace(csv).write(line);
}

void ResultTable::section(const std::string& title)
{
    say("\n{}\n", title);
    widths_.clear();
}

void ResultTable::row(const Figures& shown, const Figures& filed)
{
    if (!shown.empty()) print(shown);
    Figures row = about_;
    row.insert(row.end(), shown.begin(), shown.end()), row.insert(row.end(), filed.begin(), filed.end());
    if (file_) {
        std::vector<std::string_view> names;
        for (const Figure& figure : row) names.push_back(figure.name);
        if (!csv_) csv_.emplace(*file_, fmt::format("{}", fmt::join(names, ",")));
        for (const Figure& figure : row)
            std::visit(OneOf{[&](std::monostate) { csv_->add(std::nullopt); },
                             [&](double x) {
                                 csv_->add(Digits{x, file_digits});
                             },
                             [&](const auto& value) { csv_->add(value); }},
                       figure.value);
        csv_->end_row();
    }
    rows_.push_back(std::move(row));
}

void ResultTable::print_names(const Figures& shown)
{
    auto next = text_widths_.begin();
    std::string line;
    for (const Figure& figure : shown) {
        const std::string title = title_of(figure.name);
        if (is_text(figure)) {
            const int given = next == text_widths_.end() ? least_text : *next++;
            widths_.push_back(-std::max(given, int(title.size()) + 2));
            line += fmt::format("{}{:<{}}", widths_.size() > 1 && widths_.end()[-2] > 0 ? "  " : "", title,
                                -widths_.back());
        } else {
            widths_.push_back(
                std::max({least_number, int(title.size()) + 2, int(shown_text(figure.value).size()) + 2}));
            line += fmt::format("{:>{}}", title, widths_.back());
        }
    }
    say("{}\n", line);
}

void ResultTable::print(const Figures& shown)
{
    if (widths_.empty()) print_names(shown);
    std::string line;
    for (std::size_t k = 0; k < shown.size(); ++k) {
        const std::string text = shown_text(shown[k].value);
        if (widths_[k] > 0)
            line += fmt::format(" {:>{}}", text, widths_[k] - 1);
        else
            line += fmt::format("{}{:<{}} ", k > 0 && widths_[k - 1] > 0 ? "  " : "", text, -widths_[k] - 1);
    }
    say("{}\n", line.substr(0, line.find_last_not_of(' ') + 1));
    flush_stdout();
}

void ResultTable::commit()
{
    if (file_) file_->commit();
}

void ResultTable::write(JsonWriter& json, int indent) const
{
    json.begin_array();
    for (const Figures& row : rows_) {
        json.line(indent), json.begin_object();
        for (const Figure& figure : row) {
            json.key(figure.name);
            std::visit(OneOf{[&](std::monostate) { json.value(nullptr); }, [&](Digits x) { json.value(x.value); },
                             [&](const auto& value) { json.value(value); }},
                       figure.value);
        }
        json.end_object();
    }
    json.end_array();
}

} // namespace oncollide::tools
