#include <oncollide/scenes/files/terrain/height_raster.hpp>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

void check_size(const std::string& name, std::uint64_t columns, std::uint64_t rows, std::size_t size,
                std::uint64_t bytes)
{
    constexpr std::uint64_t most = 0xffffffff;
    if (columns > most || rows > most || bytes % size != 0 || rows * columns != bytes / size)
        refuse(name, fmt::format("{} x {} heights of {} bytes are announced, but there are {} bytes for them", columns,
                                 rows, size, bytes));
}

} // namespace oncollide
