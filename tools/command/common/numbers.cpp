#include "common/numbers.hpp"

#include <cctype>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide::tools {

void refuse_numbers(const std::string& option, const std::string& text, const std::string& why, const char* form)
{
    throw Error(ErrorKind::usage, fmt::format("{} \"{}\": {}; expected \"{}\"", option, text, why, form));
}

std::vector<double> parse_numbers(const std::string& option, const std::string& text, std::size_t count,
                                  const char* form)
{
    std::vector<double> numbers;
    const char *at = text.data(), *end = at + text.size();
    while (true) {
        while (at != end && (std::isspace(static_cast<unsigned char>(*at)) || *at == ',')) ++at;
        if (at == end) break;
        if (*at == '+') ++at; // from_chars takes no plus sign
        double value = 0;
        const auto [next, error] = std::from_chars(at, end, value);
        const bool ends = next == end || *next == ',' || std::isspace(static_cast<unsigned char>(*next));
        if (error == std::errc::result_out_of_range || (error == std::errc{} && !std::isfinite(value)))
            refuse_numbers(option, text, fmt::format("number {} is not finite", numbers.size() + 1), form);
        if (error != std::errc{} || !ends)
            refuse_numbers(option, text, fmt::format("number {} cannot be read", numbers.size() + 1), form);
        numbers.push_back(value);
        at = next;
    }
    if (numbers.size() != count) refuse_numbers(option, text, fmt::format("{} numbers", numbers.size()), form);
    return numbers;
}

Eigen::Isometry3d parse_pose(const std::string& option, const std::string& text, double& length)
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    length = 1;
    if (text.empty()) return pose;
    constexpr const char* form = "x y z qx qy qz qw";
    const std::vector<double> numbers = parse_numbers(option, text, 7, form);
    Eigen::Quaterniond rotation(numbers[6], numbers[3], numbers[4], numbers[5]);
    length = rotation.coeffs().stableNorm();
    if (!(length > 1e-12) || !std::isfinite(length))
        refuse_numbers(option, text, "the quaternion has no direction", form);
    rotation.coeffs() /= length;
    pose.linear() = rotation.normalized().toRotationMatrix();
    pose.translation() << numbers[0], numbers[1], numbers[2];
    return pose;
}

} // namespace oncollide::tools
