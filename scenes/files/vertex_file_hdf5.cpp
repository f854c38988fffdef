#include <oncollide/scenes/files/scene_file.hpp>

#include <array>
#include <cerrno>
#include <cstring>
#include <exception>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/scenes/files/tables/hdf5_writing.hpp>

namespace oncollide {

namespace {

namespace fs = std::filesystem;
using namespace hdf5_writing;
using Extent = std::array<hsize_t, 3>; // frames, vertices, coordinates

/// A dataset without frames; each of its chunks is a frame.
Hdf5Handle make_vertices(hid_t file, hsize_t vertices)
{
    const Hdf5& h5 = hdf5();
    const Extent none{0, vertices, 3}, any{H5S_UNLIMITED, vertices, 3}, frame{1, vertices, 3};
    const Hdf5Handle extent = space(h5.H5Screate_simple(3, none.data(), any.data())),
                     plan = properties(h5.dataset_creation);
    sure(h5.H5Pset_chunk(plan.id(), 3, frame.data()));
    return {sure(h5.H5Dcreate2(file, "vertices", h5.native_double, extent.id(), H5P_DEFAULT, plan.id(), H5P_DEFAULT)),
            h5.H5Dclose};
}

} // namespace

struct VertexFile::Open {
    fs::path path, part; ///< the file's name, and its name until it is complete
    Hdf5Handle file, vertices;
};

VertexFile::VertexFile(const fs::path& path) : name_(path.string())
{
    hdf5();
    check_writable(path);
    open_ = std::make_unique<Open>();
    open_->path = path, open_->part = fs::path(path).concat(".part");
    try {
        errno = 0;
        open_->file = create(open_->part);
    } catch (const Failed&) {
        fail();
    }
}

VertexFile::~VertexFile()
{
    if (!open_) return;
    const fs::path part = open_->part;
    open_.reset();
    std::error_code ignored;
    fs::remove(part, ignored);
}

void VertexFile::add(std::span<const Eigen::Vector3d> positions)
{
    if (!open_) throw Error(ErrorKind::usage, name_ + ": is closed; no frame can be added");
    if (positions.empty() || (frames_ && positions.size() != vertices_))
        throw Error(ErrorKind::usage,
                    fmt::format("{}: frame {} has {} vertices; {}", name_, frames_, positions.size(),
                                frames_ ? fmt::format("the first has {}", vertices_) : "there must be one at least"));
    try {
        const Hdf5& h5 = hdf5();
        errno = 0;
        if (frames_ == 0) open_->vertices = make_vertices(open_->file.id(), vertices_ = positions.size());
        const Extent start{frames_, 0, 0}, frame{1, vertices_, 3}, all{frames_ + 1, vertices_, 3};
        const hid_t vertices = open_->vertices.id();
        sure(h5.H5Dset_extent(vertices, all.data()));
        const Hdf5Handle memory = space(h5.H5Screate_simple(3, frame.data(), nullptr)),
                         there = space(h5.H5Dget_space(vertices));
        sure(h5.H5Sselect_hyperslab(there.id(), H5S_SELECT_SET, start.data(), nullptr, frame.data(), nullptr));
        sure(h5.H5Dwrite(vertices, h5.native_double, memory.id(), there.id(), H5P_DEFAULT, positions.data()));
    } catch (const Failed&) {
        fail();
    }
    ++frames_;
}

void VertexFile::close()
{
    if (!open_) return;
    if (frames_ == 0) throw Error(ErrorKind::cannot_write, name_ + ": has no frame");
    try {
        errno = 0;
        open_->vertices = {};
        sure(hdf5().H5Fflush(open_->file.id(), H5F_SCOPE_LOCAL));
        open_->file = {};
    } catch (const Failed&) {
        fail();
    }
    std::error_code error;
    fs::rename(open_->part, open_->path, error);
    if (error) throw Error(ErrorKind::cannot_write, fmt::format("{}: cannot write: {}", name_, error.message()));
    open_.reset();
}

/// Leaves open objects open until the program ends: closing them would write.
void VertexFile::fail()
{
    const std::string why = errno ? std::strerror(errno) : "HDF5 cannot write it";
    std::error_code ignored;
    fs::remove(open_->part, ignored);
    static_cast<void>(open_.release());
    throw Error(ErrorKind::cannot_write, fmt::format("{}: cannot write: {}", name_, why));
}

} // namespace oncollide
