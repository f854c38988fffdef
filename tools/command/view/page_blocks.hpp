#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

namespace oncollide::tools {

/// Binary columns for a page's script, one after the other, little-endian. Each is aligned to the size of its numbers
/// if columns of wider numbers come first.
class PageBlock {
public:
    template <class Number>
    void add(std::span<const Number> column)
    {
        static_assert(std::endian::native == std::endian::little);
        bytes_.append(reinterpret_cast<const char*>(column.data()), column.size_bytes());
    }
    template <class Number>
    void add(const std::vector<Number>& column)
    {
        add(std::span<const Number>(column));
    }
    std::string_view bytes() const { return bytes_; }

private:
    std::string bytes_;
};

inline void append(std::vector<float>& column, const Eigen::Vector3d& v)
{
    for (int axis = 0; axis < 3; ++axis) column.push_back(static_cast<float>(v[axis]));
}

/// x y z w, rounded to 2^-16.
inline void append(std::vector<std::int16_t>& column, const Eigen::Quaterniond& q)
{
    for (const double x : {q.x(), q.y(), q.z(), q.w()})
        column.push_back(static_cast<std::int16_t>(std::lround(32767 * std::clamp(x, -1.0, 1.0))));
}

} // namespace oncollide::tools
