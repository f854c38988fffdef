#pragma once
#include <cstdint>
#include <string>

#include <Eigen/Geometry>

#include <oncollide/base/function_ref.hpp>

namespace oncollide {

/// Poses of some bodies, frame by frame, recorded by another program. They are read while they are played, so a
/// recording may be larger than the memory. Not thread-safe.
class Recording {
public:
    virtual ~Recording() = default;

    /// Calls take(number from 0, pose) for each of its bodies with the poses at `frame`; after the last frame, with the
    /// last poses. Throws Error{bad_data} if the file cannot be read, and for a pose that is not rigid; the message
    /// then names the frame and, by `name_of(number)`, the body.
    virtual void read(std::uint64_t frame, FunctionRef<void(std::uint32_t, const Eigen::Isometry3d&)> take,
                      FunctionRef<std::string(std::uint32_t)> name_of) = 0;

    std::uint64_t frames = 0;
    std::uint32_t first = 0, bodies = 0; ///< bodies `first` to `first + bodies - 1` of the scene
    std::string file, path;              ///< path: within an HDF5 file
};

} // namespace oncollide
