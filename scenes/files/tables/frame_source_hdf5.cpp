#include <oncollide/scenes/files/tables/frame_source.hpp>
#include <oncollide/scenes/files/tables/hdf5_file.hpp>

namespace oncollide {

namespace {

class Hdf5Frames final : public FrameSource {
public:
    Hdf5Frames(const FrameFile& file, std::uint64_t row)
        : file_(file.file), data_(file_.column(file.path, Hdf5File::Numbers::real, {0, row})), row_(row)
    {
        frames = data_.rows(), rows = data_.extent(1);
    }

    void read(std::uint64_t frame, std::uint64_t first, std::uint64_t count, std::vector<double>& numbers) override
    {
        numbers.resize(row_ * count);
        data_.read_within(frame, first, count, numbers.data());
    }

private:
    Hdf5File file_;
    Hdf5Column data_;
    std::uint64_t row_;
};

} // namespace

std::unique_ptr<FrameSource> open_hdf5_frames(const FrameFile& file, std::uint64_t row)
{
    return std::make_unique<Hdf5Frames>(file, row);
}

} // namespace oncollide
