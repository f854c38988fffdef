#include <cmath>
#include <memory>

#include <cpl_error.h>
#include <cpl_string.h>
#include <fmt/format.h>
#include <gdal.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/scenes/files/common/loaded_library.hpp>
#include <oncollide/scenes/files/terrain/height_raster.hpp>
#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide {

namespace {

/// Loaded on first use: linking GDAL and its hundred libraries would add 80 ms to every start of a program.
class Gdal {
    const LoadedLibrary library_{ONCOLLIDE_GDAL_LIBRARY, "reads such files", "libgdal32"};

public:
#define ONCOLLIDE_GDAL_FUNCTION(name)                                                                                  \
    decltype(&::name) const name = reinterpret_cast<decltype(&::name)>(library_.find(#name))
    ONCOLLIDE_GDAL_FUNCTION(CPLPushErrorHandler);
    ONCOLLIDE_GDAL_FUNCTION(CPLPopErrorHandler);
    ONCOLLIDE_GDAL_FUNCTION(CPLQuietErrorHandler);
    ONCOLLIDE_GDAL_FUNCTION(CPLErrorReset);
    ONCOLLIDE_GDAL_FUNCTION(CPLGetLastErrorMsg);
    ONCOLLIDE_GDAL_FUNCTION(GDALAllRegister);
    ONCOLLIDE_GDAL_FUNCTION(GDALOpen);
    ONCOLLIDE_GDAL_FUNCTION(GDALClose);
    ONCOLLIDE_GDAL_FUNCTION(GDALGetFileList);
    ONCOLLIDE_GDAL_FUNCTION(CSLDestroy);
    ONCOLLIDE_GDAL_FUNCTION(GDALGetRasterCount);
    ONCOLLIDE_GDAL_FUNCTION(GDALGetRasterBand);
    ONCOLLIDE_GDAL_FUNCTION(GDALGetRasterBandXSize);
    ONCOLLIDE_GDAL_FUNCTION(GDALGetRasterBandYSize);
    ONCOLLIDE_GDAL_FUNCTION(GDALGetRasterDataType);
    ONCOLLIDE_GDAL_FUNCTION(GDALDataTypeIsComplex);
    ONCOLLIDE_GDAL_FUNCTION(GDALGetRasterNoDataValue);
    ONCOLLIDE_GDAL_FUNCTION(GDALGetGeoTransform);
    ONCOLLIDE_GDAL_FUNCTION(GDALRasterIO);
    ONCOLLIDE_GDAL_FUNCTION(GDALGetRasterScale);
    ONCOLLIDE_GDAL_FUNCTION(GDALGetRasterOffset);
#undef ONCOLLIDE_GDAL_FUNCTION

    Gdal()
    {
        GDALAllRegister();
    }
};

/// Suppresses GDAL's error output on the terminal.
struct Quiet {
    const Gdal& gdal;

    explicit Quiet(const Gdal& g) : gdal(g)
    {
        gdal.CPLPushErrorHandler(gdal.CPLQuietErrorHandler), gdal.CPLErrorReset();
    }
    ~Quiet() { gdal.CPLPopErrorHandler(); }
};

/// Prevents a small file that announces a large raster from filling the memory or taking hours.
void check_announced(const Gdal& gdal, GDALDatasetH data, const std::string& name, const HeightRaster& raster)
{
    constexpr std::uint64_t most_of_small_files = 20'000'000, most_a_byte = 64; // compressed, or sparse
    const std::uint64_t heights = std::uint64_t(raster.columns) * raster.rows;
    if (heights > Terrain::most_cells)
        refuse(name, fmt::format("{} x {} heights are announced; at most {} are possible", raster.columns, raster.rows,
                                 Terrain::most_cells));
    std::uint64_t bytes = 0;
    char** const files = gdal.GDALGetFileList(data);
    for (char** file = files; file && *file; ++file) {
        std::error_code none;
        if (const std::uintmax_t size = std::filesystem::file_size(*file, none); !none) bytes += size;
    }
    gdal.CSLDestroy(files);
    if (heights > most_of_small_files && heights / most_a_byte > bytes)
        refuse(name, fmt::format("{} x {} heights are announced; {} bytes are too few for them", raster.columns,
                                 raster.rows, bytes));
}

} // namespace

HeightRaster read_with_gdal(const std::filesystem::path& path)
{
    const std::string name = path.string();
    check_readable(path);
    static const Gdal gdal;
    const Quiet quiet(gdal);
    const auto fail = [&](const char* what) {
        const std::string why = gdal.CPLGetLastErrorMsg();
        refuse(name, why.empty() ? std::string(what) : fmt::format("{}: {}", what, why));
    };
    const auto close = [](void* dataset) { gdal.GDALClose(dataset); };
    const std::unique_ptr<void, void (*)(void*)> data(gdal.GDALOpen(name.c_str(), GA_ReadOnly), close);
    if (!data) fail("GDAL cannot read the file");
    if (gdal.GDALGetRasterCount(data.get()) < 1) fail("the file has no raster");
    GDALRasterBandH band = gdal.GDALGetRasterBand(data.get(), 1);

    HeightRaster raster;
    raster.columns = static_cast<std::uint32_t>(gdal.GDALGetRasterBandXSize(band));
    raster.rows = static_cast<std::uint32_t>(gdal.GDALGetRasterBandYSize(band));
    check_announced(gdal, data.get(), name, raster);
    const GDALDataType type = gdal.GDALGetRasterDataType(band);
    if (gdal.GDALDataTypeIsComplex(type)) fail("the raster holds complex numbers");
    raster.whole = type != GDT_Float32 && type != GDT_Float64;
    int there = 0;
    if (const double no_data = gdal.GDALGetRasterNoDataValue(band, &there); there) raster.no_data = no_data;
    double to_world[6];
    const bool placed = gdal.GDALGetGeoTransform(data.get(), to_world) == CE_None;
    if (placed) {
        if (to_world[2] != 0 || to_world[4] != 0) fail("the raster is rotated relative to the axes");
        raster.spacing = Eigen::Vector2d(std::abs(to_world[1]), std::abs(to_world[5]));
    }
    // Reads row by row, so that a short file fails at its end, before memory for all rows is allocated.
    const bool from_north = !placed || to_world[5] < 0;
    std::vector<double> row(raster.columns);
    for (std::uint32_t r = 0; r < raster.rows; ++r) {
        const auto line = static_cast<int>(from_north ? raster.rows - 1 - r : r);
        if (gdal.GDALRasterIO(band, GF_Read, 0, line, static_cast<int>(raster.columns), 1, row.data(),
                              static_cast<int>(raster.columns), 1, GDT_Float64, 0, 0) != CE_None)
            fail("GDAL cannot read all of the raster");
        raster.heights.insert(raster.heights.end(), row.begin(), row.end());
    }
    const double scale = gdal.GDALGetRasterScale(band, &there), offset = gdal.GDALGetRasterOffset(band, &there);
    if (scale != 1 || offset != 0) {
        raster.whole = false;
        for (double& height : raster.heights)
            if (!raster.no_data || height != *raster.no_data) height = height * scale + offset;
    }
    return raster;
}

} // namespace oncollide
