#pragma once
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>

#include <oncollide/base/text_sink.hpp>

namespace oncollide {

/// Buffers text whose heading is known only later: a megabyte in memory, the rest in an unnamed file, which disappears
/// however the program ends.
class Spool final : public TextSink {
public:
    /// @param folder  the file's folder; if empty or unsuitable, the system's folder for temporary files
    explicit Spool(std::filesystem::path folder = {}) : TextSink(std::size_t(1) << 20), folder_(std::move(folder)) {}

    /// Passes all text to `take`, in pieces.
    void read(const std::function<void(std::string_view)>& take) const;

private:
    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    void flush() override; ///< Throws Error{cannot_write} when the disk is full.

    std::filesystem::path folder_;
    std::unique_ptr<std::FILE, Close> file_; ///< text before the buffer; null if all text is in the buffer
};

} // namespace oncollide
