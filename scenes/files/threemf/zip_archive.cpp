#include <oncollide/scenes/files/threemf/zip_archive.hpp>

#include <algorithm>

#include <fmt/format.h>
#include <zip.h>

#include <oncollide/base/text/printable.hpp>

namespace oncollide {

struct ZipArchive::Handle {
    zip_t* archive = nullptr;
    std::uint64_t unpacked = 0; ///< bytes

    explicit Handle(const MeshSource& source)
    {
        zip_error_t error;
        zip_error_init(&error);
        zip_source_t* const bytes = zip_source_buffer_create(source.bytes.data(), source.bytes.size(), 0, &error);
        if (bytes) archive = zip_open_from_source(bytes, ZIP_RDONLY | ZIP_CHECKCONS, &error);
        if (!archive && bytes) zip_source_free(bytes);
        const std::string why = archive ? "" : zip_error_strerror(&error);
        zip_error_fini(&error);
        if (!archive) source.fail(fmt::format("not a valid zip archive, as a 3MF file must be: {}", why));
    }
    ~Handle() { zip_discard(archive); }
};

ZipArchive::ZipArchive(const MeshSource& source) : source_(source), handle_(std::make_unique<Handle>(source)) {}

ZipArchive::~ZipArchive() = default;

bool ZipArchive::has(const std::string& name) const
{
    return zip_name_locate(handle_->archive, name.c_str(), ZIP_FL_NOCASE) >= 0;
}

void ZipArchive::read(const std::string& name, const std::function<void(std::string_view)>& visit) const
{
    constexpr std::uint64_t most = std::uint64_t{2} << 30, always = std::uint64_t{16} << 20, ratio = 100;
    const auto fail = [&](const std::string& why) { source_.fail(fmt::format("{}: {}", printable(name), why)); };
    // The file is opened by index: OPC names are compared without regard to case.
    const zip_int64_t index = zip_name_locate(handle_->archive, name.c_str(), ZIP_FL_NOCASE);
    if (index < 0) fail("the archive has no such file");
    const auto close = [](zip_file_t* file) { zip_fclose(file); };
    const std::unique_ptr<zip_file_t, decltype(close)> file(
        zip_fopen_index(handle_->archive, static_cast<zip_uint64_t>(index), 0), close);
    if (!file) fail(zip_strerror(handle_->archive));
    const std::uint64_t allowed = always + ratio * source_.bytes.size();
    const auto check = [&](std::uint64_t unpacked) {
        if (unpacked > allowed)
            fail(fmt::format("it unpacks to more than {} times the archive and {} MiB", ratio, always >> 20));
    };
    zip_stat_t stat; // the size in the directory is checked before any work; the unpacked bytes are counted as well
    if (zip_stat_index(handle_->archive, static_cast<zip_uint64_t>(index), 0, &stat) == 0 && stat.valid & ZIP_STAT_SIZE)
        check(handle_->unpacked + std::min<std::uint64_t>(stat.size, most));
    std::string piece(std::size_t{1} << 20, '\0');
    for (std::uint64_t total = 0;;) {
        const zip_int64_t length = zip_fread(file.get(), piece.data(), piece.size());
        if (length < 0) fail(zip_file_strerror(file.get()));
        if (length == 0) return;
        total += static_cast<std::uint64_t>(length);
        if (total > most) fail("it unpacks to more than 2 GiB");
        handle_->unpacked += static_cast<std::uint64_t>(length);
        check(handle_->unpacked);
        visit(std::string_view(piece).substr(0, static_cast<std::size_t>(length)));
    }
}

} // namespace oncollide
