#include <cmath>
#include <memory>
#include <mutex>

#include <cpl_error.h>
#include <fmt/format.h>
#include <gdal.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/file_bytes.hpp>
#include <oncollide/scenes/files/terrain/height_raster.hpp>
#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide {

namespace {

/// GDAL writes its errors to the terminal otherwise.
struct Quiet {
    Quiet() { CPLPushErrorHandler(CPLQuietErrorHandler), CPLErrorReset(); }
    ~Quiet() { CPLPopErrorHandler(); }
};

} // namespace

HeightRaster read_with_gdal(const std::filesystem::path& path)
{
    const std::string name = path.string();
    check_readable(path);
    static std::once_flag once;
    std::call_once(once, GDALAllRegister);
    const Quiet quiet;
    const auto fail = [&](const char* what) {
        const std::string why = CPLGetLastErrorMsg();
        refuse(name, why.empty() ? std::string(what) : fmt::format("{}: {}", what, why));
    };
    const std::unique_ptr<void, void (*)(void*)> data(GDALOpen(name.c_str(), GA_ReadOnly),
                                                      [](void* dataset) { GDALClose(dataset); });
    if (!data) fail("GDAL cannot read the file");
    if (GDALGetRasterCount(data.get()) < 1) fail("the file has no raster");
    GDALRasterBandH band = GDALGetRasterBand(data.get(), 1);

    HeightRaster raster;
    raster.columns = static_cast<std::uint32_t>(GDALGetRasterBandXSize(band));
    raster.rows = static_cast<std::uint32_t>(GDALGetRasterBandYSize(band));
    if (std::uint64_t(raster.columns) * raster.rows > Terrain::most_cells) fail("the raster is too large");
    const GDALDataType type = GDALGetRasterDataType(band);
    if (GDALDataTypeIsComplex(type)) fail("the raster holds complex numbers");
    raster.whole = type != GDT_Float32 && type != GDT_Float64;
    int there = 0;
    if (const double no_data = GDALGetRasterNoDataValue(band, &there); there) raster.no_data = no_data;
    double to_world[6];
    const bool placed = GDALGetGeoTransform(data.get(), to_world) == CE_None;
    if (placed) {
        if (to_world[2] != 0 || to_world[4] != 0) fail("the raster is turned against the axes");
        raster.spacing = Eigen::Vector2d(std::abs(to_world[1]), std::abs(to_world[5]));
    }
    // Row by row: what a short file announces is read as far as it goes, before there is room for all of it.
    const bool from_north = !placed || to_world[5] < 0;
    std::vector<double> row(raster.columns);
    for (std::uint32_t r = 0; r < raster.rows; ++r) {
        const auto line = static_cast<int>(from_north ? raster.rows - 1 - r : r);
        if (GDALRasterIO(band, GF_Read, 0, line, static_cast<int>(raster.columns), 1, row.data(),
                         static_cast<int>(raster.columns), 1, GDT_Float64, 0, 0) != CE_None)
            fail("GDAL cannot read all of the raster");
        raster.heights.insert(raster.heights.end(), row.begin(), row.end());
    }
    const double scale = GDALGetRasterScale(band, &there), offset = GDALGetRasterOffset(band, &there);
    if (scale != 1 || offset != 0) {
        raster.whole = false;
        for (double& height : raster.heights)
            if (!raster.no_data || height != *raster.no_data) height = height * scale + offset;
    }
    return raster;
}

} // namespace oncollide
