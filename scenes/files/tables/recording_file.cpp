#include <oncollide/scenes/files/tables/body_table.hpp>
#include <oncollide/scenes/files/tables/recording_file.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <fstream>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/scenes/files/common/npy.hpp>
#include <oncollide/scenes/files/json/at_node.hpp>

namespace oncollide {

namespace {

constexpr std::uint64_t numbers_each = 7;

class RecordingFile final : public Recording {
public:
    explicit RecordingFile(std::unique_ptr<PoseSource> source) : source_(std::move(source))
    {
        frames = source_->frames, bodies = static_cast<std::uint32_t>(source_->bodies);
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
    std::unique_ptr<PoseSource> source_;
    std::vector<double> numbers_;
};

class NpyPoses final : public PoseSource {
public:
    explicit NpyPoses(const std::filesystem::path& path) : name_(path.string())
    {
        check_readable(path);
        in_.open(path, std::ios::binary);
        constexpr std::size_t longest_header = 70'000;
        std::string bytes(longest_header, '\0');
        in_.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        bytes.resize(static_cast<std::size_t>(in_.gcount()));
        const NpyHeader header = read_npy_header(name_, bytes);
        type_ = header.type, begin_ = header.bytes;
        if (header.shape.size() != 3 || header.shape[2] != numbers_each || header.columns_first)
            refuse(name_, fmt::format("the shape is {}{}; it must be (frames, bodies, 7), in the order of C",
                                      header.shape_text, header.columns_first ? ", in the order of Fortran" : ""));
        if (type_.kind != 'f') refuse(name_, "holds whole numbers; poses must be real ones");
        frames = header.shape[0], bodies = header.shape[1];
        const double wanted = double(frames) * double(bodies) * double(numbers_each * type_.size);
        const std::uintmax_t found = bytes_of_file(path) - begin_;
        if (wanted != double(found))
            refuse(name_, fmt::format("{} numbers of {} bytes are announced, and {} bytes are there", header.shape_text,
                                      type_.size, found));
    }

    void read(std::uint64_t frame, std::uint64_t first, std::uint64_t count, std::vector<double>& numbers) override
    {
        const std::size_t of_a_body = numbers_each * type_.size;
        bytes_.resize(count * of_a_body);
        in_.clear();
        in_.seekg(static_cast<std::streamoff>(begin_ + (frame * bodies + first) * of_a_body));
        in_.read(bytes_.data(), static_cast<std::streamsize>(bytes_.size()));
        if (in_.gcount() != static_cast<std::streamsize>(bytes_.size()))
            refuse(name_, fmt::format("frame {}: cannot be read; the file was cut off", frame));
        numbers = decoded(type_, bytes_);
    }

private:
    std::string name_;
    std::ifstream in_;
    SampleType type_{};
    std::size_t begin_ = 0;
    std::string bytes_;
};

} // namespace

std::unique_ptr<PoseSource> open_npy_poses(const std::filesystem::path& path)
{
    return std::make_unique<NpyPoses>(path);
}

std::shared_ptr<Recording> open_recording(const Node& entry, const std::filesystem::path& folder)
{
    entry.only({"file", "path", "first"});
    const std::filesystem::path path = file_of(entry["file"], folder);
    const std::string kind = path.extension().string();
    const bool hdf5 = kind == ".h5" || kind == ".hdf5";
    if (!hdf5 && kind != ".npy")
        entry["file"].fail(fmt::format("unknown kind of recording '{}'; known are .npy, .h5, .hdf5", kind));
    if (!hdf5 && entry.has("path")) entry["path"].fail("is for HDF5 files");
    const std::string dataset = !hdf5 ? "" : entry.has("path") ? std::string(entry["path"].text()) : "poses";
    return open_recording(path, dataset,
                          entry.has("first") ? static_cast<std::uint32_t>(entry["first"].integer(0, most_bodies)) : 0);
}

std::shared_ptr<Recording> open_recording(const std::filesystem::path& path, const std::string& dataset,
                                          std::uint32_t first)
{
    auto source = dataset.empty() ? open_npy_poses(path) : open_hdf5_poses(path, dataset);
    if (source->frames == 0 || source->bodies == 0 || source->bodies > most_bodies)
        refuse(path.string(), fmt::format("{} frames of {} bodies; there must be one at least, and at most {} bodies",
                                          source->frames, source->bodies, most_bodies));
    auto recording = std::make_shared<RecordingFile>(std::move(source));
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
