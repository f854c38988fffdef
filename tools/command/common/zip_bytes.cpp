#include "common/zip_bytes.hpp"

#include <ctime>
#include <memory>

#include <fmt/format.h>
#include <zip.h>

#include <oncollide/base/error.hpp>

namespace oncollide::tools {
namespace {

[[noreturn]] void fail(const char* why)
{
    throw Error(ErrorKind::internal, fmt::format("libzip: {}", why));
}

/// Owns a source beside the archive, which also owns it.
using ZipSource = std::unique_ptr<zip_source_t, decltype(&zip_source_free)>;

std::string bytes_of(zip_source_t* source)
{
    zip_stat_t about;
    if (zip_source_stat(source, &about) < 0 || zip_source_open(source) < 0) fail("the archive cannot be read");
    std::string bytes(about.size, '\0');
    const zip_int64_t read = zip_source_read(source, bytes.data(), bytes.size());
    zip_source_close(source);
    if (read != static_cast<zip_int64_t>(bytes.size())) fail("the archive cannot be read");
    return bytes;
}

} // namespace

std::string zip_bytes(const std::vector<std::pair<std::string, std::string>>& files, std::int64_t time)
{
    zip_error_t error;
    zip_error_init(&error);
    const ZipSource source(zip_source_buffer_create(nullptr, 0, 0, &error), zip_source_free);
    if (!source) fail(zip_error_strerror(&error));
    zip_source_keep(source.get());
    zip_t* const archive = zip_open_from_source(source.get(), ZIP_TRUNCATE, &error);
    if (!archive) fail(zip_error_strerror(&error));
    for (const auto& [name, bytes] : files) {
        zip_source_t* const content = zip_source_buffer(archive, bytes.data(), bytes.size(), 0);
        const zip_int64_t index = content ? zip_file_add(archive, name.c_str(), content, ZIP_FL_ENC_UTF_8) : -1;
        if (index < 0 || zip_file_set_mtime(archive, zip_uint64_t(index), std::time_t(time), 0) < 0) {
            const std::string why = zip_strerror(archive);
            zip_discard(archive);
            fail(why.c_str());
        }
    }
    if (zip_close(archive) < 0) {
        const std::string why = zip_strerror(archive);
        zip_discard(archive);
        fail(why.c_str());
    }
    return bytes_of(source.get());
}

std::string zip_version()
{
    return zip_libzip_version();
}

void check_zip(const std::string&) {}

} // namespace oncollide::tools
