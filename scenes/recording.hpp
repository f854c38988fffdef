#pragma once
#include <cstdint>
#include <string>

#include <Eigen/Geometry>

#include <oncollide/base/function_ref.hpp>

namespace oncollide {

/// Poses of some bodies, frame by frame, as another program recorded them. They are read when they are played, so a
/// recording may be larger than the memory. One thread at a time.
class Recording {
public:
    virtual ~Recording() = default;

    /// Calls take(number from 0, pose) for each of its bodies with the poses at `frame`, after the last frame with the
    /// last ones. Throws Error{bad_data} that names the frame and, by `name_of(number)`, the body whose pose is none,
    /// and where the file cannot be read.
    virtual void read(std::uint64_t frame, FunctionRef<void(std::uint32_t, const Eigen::Isometry3d&)> take,
                      FunctionRef<std::string(std::uint32_t)> name_of) = 0;

    std::uint64_t frames = 0;
    std::uint32_t first = 0, bodies = 0; ///< of the scene, from `first` on
    std::string file, path;              ///< where it is; path: within an HDF5 file
};

} // namespace oncollide
