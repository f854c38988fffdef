#include "study/pose_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/rigid.hpp>

namespace oncollide::tools {
namespace {

namespace fs = std::filesystem;

std::istringstream open(const fs::path& path)
{
    constexpr std::uintmax_t most = std::uintmax_t(1) << 30;
    return std::istringstream(std::string(without_byte_order_mark(read_file(path, most))));
}

} // namespace

std::vector<KnownPose> read_poses(const fs::path& path)
{
    std::istringstream file = open(path);
    std::vector<KnownPose> poses;
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::vector<double> numbers;
        for (std::string word; words >> word;) {
            char* end = nullptr;
            numbers.push_back(std::strtod(word.c_str(), &end)); // also hexadecimal numbers
            if (*end != 0 || !(std::abs(numbers.back()) < 1e15))
                throw Error(ErrorKind::bad_data, fmt::format("{}:{}: '{}' is not a number below 1e15", path.string(),
                                                             poses.size() + 1, word.substr(0, 40)));
        }
        if (numbers.size() != 14)
            throw Error(ErrorKind::bad_data, fmt::format("{}:{}: has {} numbers, must have 14", path.string(),
                                                         poses.size() + 1, numbers.size()));
        const double most = std::numeric_limits<int>::max();
        KnownPose pose{Eigen::Isometry3d::Identity(), int(std::clamp(numbers[0], -most, most)), numbers[1]};
        pose.b.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers.data() + 2);
        pose.b.translation() = Eigen::Map<const Eigen::Vector3d>(numbers.data() + 11);
        if (const std::string why = why_not_rigid(pose.b); !why.empty())
            throw Error(ErrorKind::bad_data, fmt::format("{}:{}: {}", path.string(), poses.size() + 1, why));
        poses.push_back(pose);
    }
    if (poses.empty()) throw Error(ErrorKind::bad_data, fmt::format("{}: has no poses", path.string()));
    return poses;
}

void read_expected(const fs::path& path, std::vector<KnownPose>& poses)
{
    std::istringstream file = open(path);
    std::size_t index, count = 0;
    for (std::uint64_t colliding, pairs; file >> index >> colliding >> pairs; ++count) {
        if (index >= poses.size())
            throw Error(ErrorKind::bad_data,
                        fmt::format("{}: pose {}, but there are only {}", path.string(), index, poses.size()));
        poses[index].colliding = colliding, poses[index].triangle_pairs = pairs;
    }
    if (count != poses.size())
        throw Error(ErrorKind::bad_data,
                    fmt::format("{}: {} results for {} poses", path.string(), count, poses.size()));
}

std::vector<KnownPose> read_known_poses(const fs::path& path)
{
    std::vector<KnownPose> poses = read_poses(path);
    const fs::path expected = path.parent_path() / (path.stem().string() + "_expected" + path.extension().string());
    if (is_regular(expected)) read_expected(expected, poses);
    return poses;
}

PoseSet pose_set(const fs::path& data_folder)
{
    const fs::path folder = data_folder / "poses";
    return {folder / "bunny_5110.obj", folder / "cow_5144.obj", folder / "bunny5110_cow5144.txt",
            folder / "bunny5110_cow5144_expected.txt"};
}

} // namespace oncollide::tools
