#pragma once
#include <algorithm>
#include <concepts>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/number_text.hpp>

namespace oncollide {

/// `text` as a field of CSV (RFC 4180), quoted only where a reader needs the quotes, or with `always`. Bytes that are
/// not UTF-8 become U+FFFD. A text that a spreadsheet would run as a formula, because it begins with = + - @, a tab or
/// a carriage return, gets an apostrophe in front.
std::string csv_field(std::string_view text, bool always = false);
/// The text of a field that csv_field() wrote: without such an apostrophe.
std::string_view csv_text(std::string_view field);

/// A text that is always quoted, needed or not.
struct Quoted {
    std::string_view text;
};
/// A text that csv_field has returned.
struct CsvField {
    std::string_view text;
};

/// Writes rows of CSV (RFC 4180, lines end with LF). Texts are quoted where necessary; numbers are the shortest text
/// that reads back as the same value; bool is 0 or 1; no value is an empty cell.
class CsvWriter {
public:
    explicit CsvWriter(TextSink& out) : out_(&out) {}
    /// @param header  the first line, without its line break
    CsvWriter(TextSink& out, std::string_view header) : out_(&out), columns_(1 + std::ranges::count(header, ','))
    {
        out_->write(header), out_->write("\n");
    }

    template <class... Cells>
    void row(const Cells&... cells)
    {
        add(cells...);
        end_row();
    }
    /// Adds cells to a row that end_row() completes.
    template <class... Cells>
    void add(const Cells&... cells)
    {
        (cell(cells), ...);
    }
    /// Throws Error{internal} if the row has other than the header's number of cells.
    void end_row()
    {
        out_->write("\n");
        if (columns_ && cells_ != columns_) throw Error(ErrorKind::internal, "CSV: a row differs from the header");
        cells_ = 0;
    }

private:
    void cell(std::string_view text) { write(csv_field(text)); }
    void cell(const std::string& text) { write(csv_field(text)); }
    void cell(const char* text) { write(csv_field(text)); }
    void cell(Quoted q) { write(csv_field(q.text, true)); }
    void cell(CsvField f) { write(f.text); }
    void cell(bool b) { write(b ? "1" : "0"); }
    void cell(double x) { separate(), out_->print("{}", x); }
    void cell(Fixed x) { separate(), out_->print("{:.{}f}", x.value, x.digits); }
    void cell(Digits x) { separate(), out_->print("{:.{}g}", x.value, x.digits); }
    void cell(Hex x) { separate(), out_->print("{:016x}", x.value); }
    void cell(std::nullopt_t) { separate(); }
    template <std::integral Integer>
    void cell(Integer x)
    {
        write(fmt::format_int(x).c_str());
    }
    template <class Value>
    void cell(const std::optional<Value>& v)
    {
        v ? cell(*v) : separate();
    }
    void write(std::string_view text) { separate(), out_->write(text); }
    void separate()
    {
        if (cells_++) out_->write(",");
    }

    TextSink* out_;
    std::ptrdiff_t columns_ = 0, cells_ = 0; ///< columns 0: unknown
};

/// A CSV file, which commit() completes.
class CsvFile {
public:
    /// @param path        empty: nothing is written
    /// @param header      the first line, as for CsvWriter
    /// @param first_line  a line before the header, with its line break; empty: none
    CsvFile(const std::filesystem::path& path, std::string_view header, std::string_view first_line = {})
    {
        if (path.empty()) return;
        file_.emplace(path).write(first_line);
        rows_.emplace(*file_, header);
    }

    template <class... Cells>
    void row(const Cells&... cells)
    {
        if (rows_) rows_->row(cells...);
    }
    CsvWriter& rows() { return *rows_; } ///< the path must not be empty
    void commit()
    {
        if (file_) file_->commit();
    }

private:
    std::optional<OutputFile> file_;
    std::optional<CsvWriter> rows_;
};

} // namespace oncollide
