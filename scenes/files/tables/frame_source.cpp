#include <oncollide/scenes/files/tables/frame_source.hpp>

#include <fstream>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/scenes/files/common/npy.hpp>
#include <oncollide/scenes/files/json/at_node.hpp>

namespace oncollide {

namespace {

class NpyFrames final : public FrameSource {
public:
    NpyFrames(const std::filesystem::path& path, std::uint64_t row, const char* what) : name_(path.string()), row_(row)
    {
        check_readable(path);
        in_.open(path, std::ios::binary);
        constexpr std::size_t longest_header = 70'000;
        std::string bytes(longest_header, '\0');
        in_.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        bytes.resize(static_cast<std::size_t>(in_.gcount()));
        const NpyHeader header = read_npy_header(name_, bytes);
        type_ = header.type, begin_ = header.bytes;
        if (header.shape.size() != 3 || header.shape[2] != row || header.columns_first)
            refuse(name_,
                   fmt::format("the shape is {}{}; it must be (frames, {}, {}), in the order of C", header.shape_text,
                               header.columns_first ? ", in the order of Fortran" : "", what, row));
        if (type_.kind != 'f') refuse(name_, "holds whole numbers; they must be real ones");
        frames = header.shape[0], rows = header.shape[1];
        const double wanted = double(frames) * double(rows) * double(row * type_.size);
        const std::uintmax_t found = bytes_of_file(path) - begin_;
        if (wanted != double(found))
            refuse(name_, fmt::format("{} numbers of {} bytes are announced, and {} bytes are there", header.shape_text,
                                      type_.size, found));
    }

    void read(std::uint64_t frame, std::uint64_t first, std::uint64_t count, std::vector<double>& numbers) override
    {
        const std::size_t of_a_row = row_ * type_.size;
        bytes_.resize(count * of_a_row);
        in_.clear();
        in_.seekg(static_cast<std::streamoff>(begin_ + (frame * rows + first) * of_a_row));
        in_.read(bytes_.data(), static_cast<std::streamsize>(bytes_.size()));
        if (in_.gcount() != static_cast<std::streamsize>(bytes_.size()))
            refuse(name_, fmt::format("frame {}: cannot be read; the file was cut off", frame));
        numbers = decoded(type_, bytes_);
    }

private:
    std::string name_;
    std::uint64_t row_;
    std::ifstream in_;
    SampleType type_{};
    std::size_t begin_ = 0;
    std::string bytes_;
};

} // namespace

FrameFile frame_file(const Node& entry, const std::filesystem::path& folder, const char* path)
{
    FrameFile found{file_of(entry["file"], folder), {}};
    const std::string kind = found.file.extension().string();
    const bool hdf5 = kind == ".h5" || kind == ".hdf5";
    if (!hdf5 && kind != ".npy")
        entry["file"].fail(fmt::format("unknown kind of recording '{}'; known are .npy, .h5, .hdf5", kind));
    if (!hdf5 && entry.has("path")) entry["path"].fail("is for HDF5 files");
    if (hdf5) found.path = entry.has("path") ? std::string(entry["path"].text()) : path;
    return found;
}

std::unique_ptr<FrameSource> open_frames(const FrameFile& file, std::uint64_t row, const char* what, std::uint64_t most)
{
    std::unique_ptr<FrameSource> source;
    if (file.path.empty())
        source = std::make_unique<NpyFrames>(file.file, row, what);
    else
        source = open_hdf5_frames(file, row);
    if (source->frames == 0 || source->rows == 0 || source->rows > most)
        refuse(file.file.string(), fmt::format("{} frames of {} {}; there must be one at least, and at most {} {}",
                                               source->frames, source->rows, what, most, what));
    return source;
}

} // namespace oncollide
