#include <oncollide/scenes/files/tables/body_table.hpp>
#include <oncollide/scenes/files/tables/frame_source.hpp>
#include <oncollide/scenes/files/tables/recording_file.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/scenes/files/common/npy.hpp>

namespace oncollide {

namespace {

constexpr std::uint64_t numbers_each = 7;

class RecordingFile final : public Recording {
public:
    explicit RecordingFile(std::unique_ptr<FrameSource> source) : source_(std::move(source))
    {
        frames = source_->frames, bodies = static_cast<std::uint32_t>(source_->rows);
    }

    void read(std::uint64_t frame, FunctionRef<void(std::uint32_t, const Eigen::Isometry3d&)> take,
              FunctionRef<std::string(std::uint32_t)> name_of) override
    {
        frame = std::min(frame, frames - 1);
        constexpr std::uint32_t block = 65'536; // bodies in memory at a time
        constexpr double farthest = 1e15, unit = 1e-3;
        for (std::uint32_t i = 0; i < bodies; ++i) {
            if (i % block == 0) source_->read(frame, i, std::min(block, bodies - i), numbers_);
            const double* const n = &numbers_[numbers_each * (i % block)];
            const Eigen::Map<const Eigen::Vector3d> position(n);
            // The order of additions of Quaterniond::norm(), without loads that wait for recent stores.
            const double length = std::sqrt((n[3] * n[3] + n[5] * n[5]) + (n[4] * n[4] + n[6] * n[6]));
            if (!(position.cwiseAbs().maxCoeff() <= farthest) || !position.allFinite() ||
                !(std::abs(length - 1) <= unit))
                refuse(file,
                       fmt::format("frame {}: {}: ({}, {}, {}), ({}, {}, {}, {}) is not a position and unit quaternion",
                                   frame, name_of(i), n[0], n[1], n[2], n[3], n[4], n[5], n[6]));
            Eigen::Quaterniond rotation(n[6], n[3], n[4], n[5]);
            if (std::abs(length - 1) > 1e-12) rotation.coeffs() /= length;
            Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
            pose.linear() = rotation.toRotationMatrix();
            pose.translation() = position;
            take(i, pose);
        }
    }

private:
    std::unique_ptr<FrameSource> source_;
    std::vector<double> numbers_;
};

} // namespace

std::shared_ptr<Recording> open_recording(const Node& entry, const std::filesystem::path& folder)
{
    entry.only({"file", "path", "first"});
    const FrameFile file = frame_file(entry, folder, "poses");
    return open_recording(file.file, file.path,
                          entry.has("first") ? static_cast<std::uint32_t>(entry["first"].integer(0, most_bodies)) : 0);
}

std::shared_ptr<Recording> open_recording(const std::filesystem::path& path, const std::string& dataset,
                                          std::uint32_t first)
{
    auto recording = std::make_shared<RecordingFile>(open_frames({path, dataset}, numbers_each, "bodies", most_bodies));
    recording->file = path.string(), recording->path = dataset, recording->first = first;
    return recording;
}

void add_recorded(const Eigen::Isometry3d& pose, std::vector<float>& numbers)
{
    const Eigen::Vector3f p = pose.translation().cast<float>();
    const Eigen::Quaternionf q = Eigen::Quaterniond(pose.linear()).cast<float>();
    numbers.insert(numbers.end(), {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()});
}

void save_recording(std::span<const float> numbers, std::size_t bodies, const std::filesystem::path& path)
{
    static_assert(std::endian::native == std::endian::little, "numbers are written as they lie");
    OutputFile file(path);
    const std::uint64_t of_a_frame = numbers_each * bodies;
    file.write(npy_header("<f4", std::array<std::uint64_t, 3>{numbers.size() / of_a_frame, bodies, numbers_each}));
    file.write({reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()});
    file.commit();
}

} // namespace oncollide
