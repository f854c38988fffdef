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

/// One point, (3,), or many, (N, 3).
class Points {
public:
    Points(py::handle value, const Place& place);
    bool one() const { return one_; }
    std::size_t size() const { return size_; }
    Eigen::Vector3d operator[](std::size_t i) const { return Eigen::Vector3d(at_ + (one_ ? 0 : 3 * i)); }

private:
    py::array array_;
    const double* at_;
    std::size_t size_;
    bool one_;
};

/// A 4 x 4 matrix, or position and quaternion x y z qx qy qz qw; None: the identity. The World checks that it is rigid.
Eigen::Isometry3d pose(py::handle value, const Place& place);

/// One pose, or many, as rows of 16 numbers: the array's own memory if it is (N, 4, 4), contiguous and of doubles.
class Poses {
public:
    /// As pose(), or (N, 4, 4), (N, 7).
    Poses(py::handle value, const Place& place, bool may_be_many = true);
    Poses(const Poses&) = delete;

    bool one() const { return one_; }
    std::size_t size() const { return rows_.size() / 16; }
    std::span<const double> rows() const { return rows_; }
    Eigen::Isometry3d operator[](std::size_t i) const; ///< one pose serves every i

private:
    py::object kept_;
    std::vector<double> made_;
    std::span<const double> rows_;
    bool one_ = true;
};

/// Checks that the arguments of a call that have many entries have equally many; one entry serves all.
class Lengths {
public:
    explicit Lengths(const char* call) : call_(call) {}
    void add(const char* argument, bool one, std::size_t entries); ///< ValueError for another length
    bool one() const { return one_; }
    std::size_t size() const { return size_; }

private:
    const char* call_;
    bool one_ = true;
    std::size_t size_ = 1;
};

/// An id in Python is an integer: the slot in the low bits, then the generation, then the World's tag. In memory an
/// array of them is an array of ids.
template <class Id>
std::uint64_t number_of(Id id)
{
    return std::uint64_t{id.world} << 48 | std::uint64_t{id.generation} << 32 | id.slot;
}
BodyId body(py::handle value, const Place& place);

/// True for an array or a sequence of values; a string and an array without axes count as one value.
bool is_many(py::handle value);

/// An id, or many, (N,): the array's own memory if it is contiguous and of uint64. Other threads of Python may change
/// that memory once they have the interpreter's lock.
class Ids {
public:
    Ids(py::handle value, const Place& place);
    Ids(const Ids&) = delete;

    bool one() const { return one_; }
    std::size_t size() const { return ids_.size(); }
    BodyId operator[](std::size_t i) const { return ids_[one_ ? 0 : i]; }
    const BodyId* begin() const { return ids_.data(); }
    const BodyId* end() const { return begin() + size(); }

private:
    py::object kept_;
    std::vector<BodyId> made_;
    BodyId single_;
    std::span<const BodyId> ids_;
    bool one_;
};
py::array ids_of(std::span<const BodyId> bodies);
py::array offsets_of(std::span<const std::size_t> offsets); ///< int64

} // namespace oncollide::python
