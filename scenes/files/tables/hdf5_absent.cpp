#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/scenes/files/tables/body_table.hpp>
#include <oncollide/scenes/files/tables/frame_source.hpp>
#include <oncollide/scenes/files/tables/number_table.hpp>
#include <oncollide/scenes/files/tables/results_file.hpp>

namespace oncollide {

namespace {

[[noreturn]] void fail(const std::filesystem::path& path)
{
    check_readable(path);
    throw Error(ErrorKind::usage,
                fmt::format("{}: this build cannot read HDF5; build on Linux with -DONCOLLIDE_HDF5=ON "
                            "(Debian: libhdf5-dev), or use another format",
                            path.string()));
}

} // namespace

void read_hdf5_bodies(BodyRows&, const std::filesystem::path& path, const std::string&)
{
    fail(path);
}

std::unique_ptr<FrameSource> open_hdf5_frames(const FrameFile& file, std::uint64_t)
{
    fail(file.file);
}

NumberTable read_hdf5_table(const std::filesystem::path& path, const std::string&)
{
    fail(path);
}

struct ResultsFile::Open {};

ResultsFile::ResultsFile(const std::filesystem::path& path, const ResultsHeader&, const NameColumn&, std::uint64_t)
    : name_(path.string())
{
    fail();
}

ResultsFile::~ResultsFile() = default;
void ResultsFile::add(std::span<const PairRow>, FrameRow, std::span<const SweepRow>) {}
void ResultsFile::close() {}

void ResultsFile::fail()
{
    throw Error(ErrorKind::usage,
                fmt::format("{}: this build cannot write HDF5; build on Linux with -DONCOLLIDE_HDF5=ON "
                            "(Debian: libhdf5-dev), or use --csv",
                            name_));
}

struct StoredResults::Open {};

StoredResults::StoredResults(const std::filesystem::path& path, const ResultsHeader&) : name_(path.string())
{
    fail(path);
}

StoredResults::~StoredResults() = default;
std::string StoredResults::unlike(const NameColumn&) const
{
    return {};
}
void StoredResults::read(const FrameRow&, std::vector<PairRow>&) const {}
void StoredResults::read(const FrameRow&, std::vector<SweepRow>&) const {}

} // namespace oncollide
