#pragma once
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/reading_progress.hpp>

namespace oncollide {

/// Splits CSV into fields as in RFC 4180; lines may also end with LF alone.
class CsvReader {
public:
    enum class Style {
        table, ///< as programs write it; a quoted field ends in its line, so that a file may be read in pieces
        list,  ///< as people write it: blanks around fields do not count, `#` at the start of a line or after a blank
               ///< begins a comment, quoted fields may contain line breaks
    };

    /// @param file  names the file in errors and in the progress of reading
    CsvReader(const std::string& file, std::string_view text, Style style = Style::table)
        : file_(file), style_(style), at_(text.data()), end_(text.data() + text.size()), begin_(at_),
          progress_(file, text.size())
    {
    }

    bool at_end() const { return at_ == end_; }
    std::size_t line() const { return line_; }
    /// Throws Error{bad_data} that names the file and the line.
    [[noreturn]] void fail(const std::string& what) const { refuse(fmt::format("{}: line {}", file_, line_), what); }

    /// The next field of the line, valid until the next call. `last`: it is the line's last one.
    std::string_view next(bool& last)
    {
        if (style_ == Style::list) return next_of_list(last);
        if (at_ != end_ && *at_ == '"') {
            quoted();
            if (at_ != end_ && *at_ == '\r') ++at_;
            pass_separator(last);
            return text_;
        }
        const char* const begin = at_;
        while (at_ != end_ && *at_ != ',' && *at_ != '\n') ++at_;
        const char* stop = at_;
        if (stop != begin && stop[-1] == '\r' && (at_ == end_ || *at_ == '\n')) --stop;
        pass_separator(last);
        return {begin, static_cast<std::size_t>(stop - begin)};
    }
    void next_line()
    {
        ++line_;
        progress_.at(static_cast<std::uint64_t>(at_ - begin_));
    }
    /// Skips the rest of the line.
    void skip_line()
    {
        const auto* const end = static_cast<const char*>(std::memchr(at_, '\n', static_cast<std::size_t>(end_ - at_)));
        at_ = end ? end + 1 : end_;
    }
    /// Continues with this text.
    void go_on(std::string_view text) { at_ = begin_ = text.data(), end_ = at_ + text.size(); }

private:
    static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
    bool at_comment() const
    {
        return at_ != end_ && *at_ == '#' && (at_ == begin_ || is_blank(at_[-1]) || at_[-1] == '\n');
    }

    std::string_view next_of_list(bool& last)
    {
        while (at_ != end_ && is_blank(*at_)) ++at_;
        std::string_view field;
        if (at_ != end_ && *at_ == '"') {
            quoted();
            field = text_;
            while (at_ != end_ && is_blank(*at_)) ++at_;
        } else {
            const char* const begin = at_;
            while (at_ != end_ && *at_ != ',' && *at_ != '\n' && !at_comment()) ++at_;
            field = {begin, static_cast<std::size_t>(at_ - begin)};
            while (!field.empty() && is_blank(field.back())) field.remove_suffix(1);
        }
        if (at_comment())
            while (at_ != end_ && *at_ != '\n') ++at_;
        pass_separator(last);
        return field;
    }
    /// Reads a quoted field into text_.
    void quoted()
    {
        const std::size_t line = line_;
        text_.clear();
        for (++at_;; ++at_) {
            if (at_ == end_ || (*at_ == '\n' && style_ == Style::table)) {
                line_ = line;
                fail("a quoted field has no closing quote");
            }
            if (*at_ == '"' && (++at_ == end_ || *at_ != '"')) break;
            line_ += *at_ == '\n';
            text_ += *at_;
        }
    }
    void pass_separator(bool& last)
    {
        last = at_ == end_ || *at_ == '\n';
        if (!last && *at_ != ',') fail("a comma or the end of the line must follow a closing quote");
        if (at_ != end_) ++at_;
    }

    const std::string& file_;
    Style style_;
    const char *at_, *end_, *begin_;
    ReadingProgress progress_; ///< for a text that is complete in memory
    std::size_t line_ = 1;
    std::string text_;
};

} // namespace oncollide
