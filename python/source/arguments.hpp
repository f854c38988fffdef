#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Geometry>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/ids.hpp>

/// What Python hands over, checked: every error names the call, the argument and what would be valid.
namespace oncollide::python {

namespace py = pybind11;

/// Where a value comes from, for messages: "World.set_pose: body".
struct Place {
    const char *call, *argument;
};

[[noreturn]] void refuse_type(const Place& place, const std::string& expected, py::handle got); ///< TypeError
[[noreturn]] void refuse_value(const Place& place, const std::string& what);                    ///< ValueError
std::string text_of(py::handle shape_or_value);

double number(py::handle value, const Place& place);                           ///< finite or not
double limit_of(py::handle value, const Place& place);                         ///< None: infinite
std::uint64_t whole(py::handle value, const Place& place, std::uint64_t most); ///< from 0 on
bool truth(py::handle value, const Place& place);                              ///< True or False, nothing else
std::string text(py::handle value, const Place& place);
std::string path(py::handle value, const Place& place); ///< str, bytes or os.PathLike

/// C-contiguous doubles: the array itself where it is such an array, else a copy of what can be made one (whole numbers
/// and floats of any size, order and stride; lists).
py::array doubles(py::handle value, const Place& place);
/// The same of whole numbers.
py::array whole_numbers(py::handle value, const Place& place);

/// Does the array have that shape? -1: any length.
bool has_shape(const py::array& array, std::initializer_list<py::ssize_t> shape);
std::string shape_of(const py::array& array);

Eigen::Vector3d vector3(py::handle value, const Place& place);
Eigen::Vector2d vector2(py::handle value, const Place& place);
std::vector<Eigen::Vector3d> points(py::handle value, const Place& place); ///< (N, 3)

/// A 4 x 4 matrix, or position and quaternion x y z qx qy qz qw; None: the identity. World and Queries check that it is
/// rigid.
Eigen::Isometry3d pose(py::handle value, const Place& place);

/// Poses of many, as rows of 16 numbers: the array's own memory where it is (N, 4, 4), contiguous and of doubles.
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

/// Ids are whole numbers in Python: the slot and, above it, the generation.
inline std::uint64_t number_of(BodyId id)
{
    return std::uint64_t{id.generation} << 32 | id.slot;
}
BodyId body(py::handle value, const Place& place);
std::vector<BodyId> bodies(py::handle value, const Place& place); ///< (N,)
py::array ids_of(std::span<const BodyId> bodies);

} // namespace oncollide::python
