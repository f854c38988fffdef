#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Geometry>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/results.hpp>

/// Conversion of Python arguments, with checks: every error names the call, the argument and the valid values.
namespace oncollide::python {

namespace py = pybind11;

/// Origin of a value, for messages: "World.set_pose: body".
struct Place {
    const char *call, *argument;
};

[[noreturn]] void refuse_type(const Place& place, const std::string& expected, py::handle got); ///< TypeError
[[noreturn]] void refuse_value(const Place& place, const std::string& what);                    ///< ValueError
std::string text_of(py::handle shape_or_value);

double number(py::handle value, const Place& place);                           ///< may be infinite or NaN
double limit_of(py::handle value, const Place& place);                         ///< None: infinite
std::uint64_t whole(py::handle value, const Place& place, std::uint64_t most); ///< from 0 on
bool truth(py::handle value, const Place& place);                              ///< only True or False
std::string text(py::handle value, const Place& place);
std::string path(py::handle value, const Place& place); ///< str, bytes or os.PathLike

/// C-contiguous doubles: the array itself if it has this form, else a converted copy (integers and floats of any size,
/// byte order and stride; lists).
py::array doubles(py::handle value, const Place& place);
/// The same for integers.
py::array whole_numbers(py::handle value, const Place& place);

/// Whether the array has that shape. -1: any length.
bool has_shape(const py::array& array, std::initializer_list<py::ssize_t> shape);
std::string shape_of(const py::array& array);

Eigen::Vector3d vector3(py::handle value, const Place& place);
Eigen::Vector2d vector2(py::handle value, const Place& place);
std::vector<Eigen::Vector3d> points(py::handle value, const Place& place); ///< (N, 3)

/// A 4 x 4 matrix, or position and quaternion x y z qx qy qz qw; None: the identity. World and Queries check that it is
/// rigid.
Eigen::Isometry3d pose(py::handle value, const Place& place);

/// Many poses, as rows of 16 numbers: the array's own memory if it is (N, 4, 4), contiguous and of doubles.
class Poses {
public:
    /// (N, 4, 4), (N, 7), or one pose for all: (4, 4), (7,).
    Poses(py::handle value, const Place& place);

    bool one() const { return one_; }
    std::size_t size() const { return rows_.size() / 16; }
    std::span<const double> rows() const { return rows_; }
    Eigen::Isometry3d operator[](std::size_t i) const;

private:
    py::array array_;
    std::vector<double> made_;
    std::span<const double> rows_;
    bool one_;
};

/// An id in Python is an integer: the slot in the low bits, the generation above.
inline std::uint64_t number_of(BodyId id)
{
    return std::uint64_t{id.world} << 48 | std::uint64_t{id.generation} << 32 | id.slot;
}
BodyId body(py::handle value, const Place& place);
std::vector<BodyId> bodies(py::handle value, const Place& place); ///< (N,)
py::array ids_of(std::span<const BodyId> bodies);
py::array offsets_of(std::span<const std::size_t> offsets); ///< int64

} // namespace oncollide::python
