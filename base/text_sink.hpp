#pragma once
#include <cstddef>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace oncollide {

/// Collects text in a buffer and passes it on in large pieces. Files, spools and texts in memory derive from it.
class TextSink {
public:
    TextSink(const TextSink&) = delete;
    TextSink& operator=(const TextSink&) = delete;

    template <class... Args>
    void print(fmt::format_string<Args...> format, Args&&... args)
    {
        print_as(format, fmt::make_format_args(args...));
    }
    /// Writes bytes unchanged.
    void write(std::string_view bytes)
    {
        buffer_.append(bytes.data(), bytes.data() + bytes.size());
        if (buffer_.size() > most_) flush();
    }

protected:
    /// @param most  bytes; when the buffer holds more, flush() is called
    explicit TextSink(std::size_t most) : most_(most) {}
    ~TextSink() = default;
    virtual void flush() = 0; ///< Takes all of the buffer and empties it.

    fmt::memory_buffer buffer_;

private:
    // Not inline: fmt's formatter is a large template, which would be compiled for every unit that prints.
    void print_as(fmt::string_view format, fmt::format_args args);

    std::size_t most_;
};

/// Text in memory.
class TextInMemory final : public TextSink {
public:
    TextInMemory() : TextSink(static_cast<std::size_t>(-1)) {}
    std::string text() const { return {buffer_.data(), buffer_.size()}; }

private:
    void flush() override {}
};

} // namespace oncollide
