#include <oncollide/scenes/files/tables/hdf5_file.hpp>
#include <oncollide/scenes/files/tables/recording_file.hpp>

namespace oncollide {

namespace {

class Hdf5Poses final : public PoseSource {
public:
    Hdf5Poses(const std::filesystem::path& path, const std::string& dataset)
        : file_(path), poses_(file_.column(dataset, Hdf5File::Numbers::real, {0, 7}))
    {
        frames = poses_.rows(), bodies = poses_.extent(1);
    }

    void read(std::uint64_t frame, std::uint64_t first, std::uint64_t count, std::vector<double>& numbers) override
    {
        numbers.resize(7 * count);
        poses_.read_within(frame, first, count, numbers.data());
    }

private:
    Hdf5File file_;
    Hdf5Column poses_;
};

} // namespace

std::unique_ptr<PoseSource> open_hdf5_poses(const std::filesystem::path& path, const std::string& dataset)
{
    return std::make_unique<Hdf5Poses>(path, dataset);
}

} // namespace oncollide
