#pragma once
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <string_view>

#include <fmt/format.h>

namespace oncollide {

/// Buffers text whose heading is known only later: a megabyte in memory, the rest in an unnamed file, which disappears
/// however the program ends.
class Spool {
public:
    /// @param folder  for the file; if empty or unsuitable, the system's folder for temporary files
    explicit Spool(std::filesystem::path folder = {}) : folder_(std::move(folder)) {}
    Spool(Spool&&) = default;

    /// Throws Error{cannot_write} when the disk is full.
    template <class... Args>
    void print(fmt::format_string<Args...> format, Args&&... args)
    {
        fmt::format_to(std::back_inserter(buffer_), format, std::forward<Args>(args)...);
        if (buffer_.size() > most_in_memory) flush();
    }
    /// Passes all text to `take`, in pieces.
    void read(const std::function<void(std::string_view)>& take) const;

private:
    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    static constexpr std::size_t most_in_memory = std::size_t{1} << 20;
    void flush();

    std::filesystem::path folder_;
    std::unique_ptr<std::FILE, Close> file_; ///< text before the buffer; null if all text is in the buffer
    fmt::memory_buffer buffer_;
};

} // namespace oncollide
