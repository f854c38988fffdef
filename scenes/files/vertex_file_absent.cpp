#include <oncollide/scenes/files/scene_file.hpp>

#include <fmt/format.h>

namespace oncollide {

struct VertexFile::Open {};

VertexFile::VertexFile(const std::filesystem::path& path) : name_(path.string())
{
    fail();
}

VertexFile::~VertexFile() = default;
void VertexFile::add(std::span<const Eigen::Vector3d>) {}
void VertexFile::close() {}

void VertexFile::fail()
{
    throw Error(ErrorKind::usage,
                fmt::format("{}: this build cannot write HDF5; build on Linux with -DONCOLLIDE_HDF5=ON "
                            "(Debian: libhdf5-dev)",
                            name_));
}

} // namespace oncollide
