#include <oncollide/scenes/motion.hpp>

#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/scenes/files/common/quaternion.hpp>

namespace oncollide {

namespace {

constexpr std::string_view blanks = " \t\r";

/// Removes the next word from the front of `line`; empty at its end.
std::string_view next_word(std::string_view& line)
{
    line.remove_prefix(std::min(line.find_first_not_of(blanks), line.size()));
    const std::string_view word = line.substr(0, line.find_first_of(blanks));
    line.remove_prefix(word.size());
    return word;
}

/// The eight numbers of a line `t x y z qx qy qz qw`.
std::array<double, 8> numbers_of(const std::string& place, std::string_view line)
{
    const auto fail = [&](const std::string& what) {
        throw Error(ErrorKind::bad_data, fmt::format("{}: {}; a line is 't x y z qx qy qz qw'", place, what));
    };
    std::array<double, 8> numbers{};
    std::size_t count = 0;
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line), ++count) {
        if (count == numbers.size()) fail("more than eight numbers");
        if (word.front() == '+') word.remove_prefix(1);
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), numbers[count]);
        if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(numbers[count]))
            fail(count == 0 ? "its first word is not a number" // another kind of file is not quoted
                            : fmt::format("'{}' is not a finite number", word.substr(0, 40)));
    }
    if (count != numbers.size()) fail(fmt::format("{} numbers instead of eight", count));
    return numbers;
}

} // namespace

Keyed load_tum(const std::filesystem::path& path, double frames_per_second, std::vector<std::string>& warnings)
{
    if (!(frames_per_second > 0 && frames_per_second <= 1e9))
        throw Error(ErrorKind::usage, fmt::format("{}: {} frames per second; must be above 0 and at most 1e9",
                                                  path.string(), frames_per_second));
    const std::string text = read_file(path, std::uintmax_t(1) << 30);
    Keyed motion;
    double first_time = 0;
    std::size_t line_number = 0;
    for (std::string_view rest = without_byte_order_mark(text); !rest.empty();) {
        const std::size_t end = std::min(rest.find('\n'), rest.size());
        std::string_view line = rest.substr(0, end);
        rest.remove_prefix(std::min(end + 1, rest.size()));
        ++line_number;
        line.remove_prefix(std::min(line.find_first_not_of(blanks), line.size()));
        if (line.empty() || line.front() == '#') continue;

        const auto place = [&] { return fmt::format("{}:{}", path.string(), line_number); };
        const std::array<double, 8> n = numbers_of(place(), line);
        if (motion.keys.empty()) first_time = n[0];
        const double frame = (n[0] - first_time) * frames_per_second;
        if (!motion.keys.empty() && !(frame > motion.keys.back().time))
            throw Error(ErrorKind::bad_data,
                        fmt::format("{}: time {} does not come after the time of the line before", place(), n[0]));
        motion.keys.push_back({frame, {n[1], n[2], n[3]}, quaternion_of(place, {n[4], n[5], n[6], n[7]}, warnings)});
    }
    if (motion.keys.empty())
        throw Error(ErrorKind::bad_data,
                    fmt::format("{}: holds no pose; a line is 't x y z qx qy qz qw'", path.string()));
    check_motion(path.string(), motion);
    return motion;
}

} // namespace oncollide
