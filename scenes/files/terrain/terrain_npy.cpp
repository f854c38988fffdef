#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/files/common/npy.hpp>
#include <oncollide/scenes/files/terrain/height_raster.hpp>

namespace oncollide {

HeightRaster read_npy(const std::string& name, std::string_view bytes)
{
    const NpyHeader header = read_npy_header(name, bytes);
    constexpr std::uint64_t most = 0xffffffffu;
    if (header.shape.size() != 2 || header.shape[0] > most || header.shape[1] > most)
        refuse(name, fmt::format("the shape is {}; it must be two numbers: rows and columns", header.shape_text));
    const std::string_view data = bytes.substr(header.bytes);
    HeightRaster raster;
    raster.rows = static_cast<std::uint32_t>(header.shape[0]);
    raster.columns = static_cast<std::uint32_t>(header.shape[1]);
    check_size(name, raster.columns, raster.rows, header.type.size, data.size());
    raster.heights = decoded(header.type, data);
    raster.whole = header.type.kind != 'f';
    if (header.columns_first) {
        std::vector<double> transposed(raster.heights.size());
        for (std::size_t i = 0; i < transposed.size(); ++i)
            transposed[i] = raster.heights[i % raster.columns * raster.rows + i / raster.columns];
        raster.heights = std::move(transposed);
    }
    return raster;
}

} // namespace oncollide
