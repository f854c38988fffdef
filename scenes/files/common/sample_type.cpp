#include <oncollide/scenes/files/common/sample_type.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

namespace {

template <class Number>
void decode(bool big, std::string_view bytes, std::vector<double>& numbers)
{
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        std::array<char, sizeof(Number)> swapped;
        std::memcpy(swapped.data(), bytes.data() + i * sizeof(Number), sizeof(Number));
        if (big != (std::endian::native == std::endian::big)) std::reverse(swapped.begin(), swapped.end());
        numbers[i] = static_cast<double>(std::bit_cast<Number>(swapped));
    }
}

} // namespace

SampleType sample_type(const std::string& name, std::string_view text)
{
    if (text.size() == 3) {
        const SampleType type{text[1], static_cast<std::size_t>(text[2] - '0'), text[0] == '>'};
        const bool order = text[0] == '<' || text[0] == '>' || (text[0] == '|' && type.size == 1);
        const bool whole =
            (type.kind == 'u' || type.kind == 'i') && (type.size == 1 || type.size == 2 || type.size == 4);
        const bool real = type.kind == 'f' && (type.size == 4 || type.size == 8);
        if (order && (whole || real)) return type;
    }
    refuse(name, fmt::format("numbers of type '{}'; known are u1, i1, u2, i2, u4, i4, f4 and f8 after < or > for the "
                             "order of bytes, as \"<i2\"",
                             text.substr(0, 40)));
}

std::vector<double> decoded(const SampleType& type, std::string_view bytes)
{
    std::vector<double> numbers(bytes.size() / type.size);
    const bool is_signed = type.kind == 'i';
    if (type.kind == 'f')
        type.size == 4 ? decode<float>(type.big, bytes, numbers) : decode<double>(type.big, bytes, numbers);
    else if (type.size == 1)
        is_signed ? decode<std::int8_t>(false, bytes, numbers) : decode<std::uint8_t>(false, bytes, numbers);
    else if (type.size == 2)
        is_signed ? decode<std::int16_t>(type.big, bytes, numbers) : decode<std::uint16_t>(type.big, bytes, numbers);
    else
        is_signed ? decode<std::int32_t>(type.big, bytes, numbers) : decode<std::uint32_t>(type.big, bytes, numbers);
    return numbers;
}

} // namespace oncollide
