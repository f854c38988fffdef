#include "arguments.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace oncollide::python {

namespace {

std::string begin(const Place& place)
{
    return fmt::format("{}: {}: ", place.call, place.argument);
}

constexpr int contiguous = int{py::array::c_style} | int{py::detail::npy_api::NPY_ARRAY_ALIGNED_};

/// Writes a pose as a matrix row by row, from x y z qx qy qz qw; the quaternion is normalised, as in scene files.
void write_rows(const double* from, double* rows, const Place& place)
{
    const Eigen::Vector4d q(from[3], from[4], from[5], from[6]);
    const double length = q.norm();
    if (!(std::abs(length - 1) <= 1e-3))
        refuse_value(place, fmt::format("the quaternion ({}, {}, {}, {}) has length {:.3g}; it must be near 1, in the "
                                        "order x, y, z, w",
                                        q[0], q[1], q[2], q[3], length));
    const Eigen::Quaterniond turn(std::abs(length - 1) > 1e-12 ? Eigen::Vector4d(q / length) : q);
    Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(rows);
    matrix.setIdentity();
    matrix.topLeftCorner<3, 3>() = turn.toRotationMatrix();
    matrix.topRightCorner<3, 1>() = Eigen::Map<const Eigen::Vector3d>(from);
}

Eigen::Isometry3d of_rows(const double* rows)
{
    Eigen::Isometry3d made;
    made.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(rows);
    return made;
}

template <class Number, char... kinds>
py::array numbers(py::handle value, const Place& place, const char* expected)
{
    using Wanted = py::array_t<Number, contiguous | py::array::forcecast>;
    if (Wanted::check_(value)) return py::reinterpret_borrow<py::array>(value);
    const py::array any = py::array::ensure(value);
    if (!any) refuse_type(place, expected, value);
    const char kind = any.dtype().kind();
    if (((kind != kinds) && ...))
        if (any.size() > 0 || py::isinstance<py::array>(value))
            refuse_type(place, fmt::format("{}, not of dtype {}", expected, text_of(any.dtype())), value);
    Wanted made = Wanted::ensure(any);
    if (!made) refuse_type(place, expected, value);
    return made;
}

} // namespace

std::string text_of(py::handle value)
{
    std::string text = py::str(value);
    if (text.size() > 60) text.replace(60, std::string::npos, "...");
    return text;
}

void refuse_type(const Place& place, const std::string& expected, py::handle got)
{
    throw py::type_error(begin(place) +
                         fmt::format("expected {}; got {}", expected, text_of(py::type::of(got).attr("__name__"))));
}

void refuse_value(const Place& place, const std::string& what)
{
    throw py::value_error(begin(place) + what);
}

double number(py::handle value, const Place& place)
{
    if (PyFloat_CheckExact(value.ptr())) return PyFloat_AS_DOUBLE(value.ptr());
    const double made = PyBool_Check(value.ptr()) ? -1 : PyFloat_AsDouble(value.ptr());
    if ((made == -1 && PyErr_Occurred()) || PyBool_Check(value.ptr())) {
        PyErr_Clear();
        refuse_type(place, "a number", value);
    }
    return made;
}

double limit_of(py::handle value, const Place& place)
{
    return value.is_none() ? std::numeric_limits<double>::infinity() : number(value, place);
}

std::uint64_t whole(py::handle value, const Place& place, std::uint64_t most)
{
    const auto wrong = [&] {
        PyErr_Clear();
        refuse_value(place, fmt::format("{} is out of range; must be from 0 to {}", text_of(value), most));
    };
    py::object kept;
    if (!PyLong_CheckExact(value.ptr())) {
        if (!PyBool_Check(value.ptr())) kept = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
        if (!kept) {
            PyErr_Clear();
            refuse_type(place, "a whole number", value);
        }
        value = kept;
    }
    const unsigned long long made = PyLong_AsUnsignedLongLong(value.ptr());
    if ((made == ~0ull && PyErr_Occurred()) || made > most) wrong();
    return made;
}

bool truth(py::handle value, const Place& place)
{
    if (value.ptr() == Py_True) return true;
    if (value.ptr() == Py_False) return false;
    if (std::string_view(Py_TYPE(value.ptr())->tp_name) == "numpy.bool_") return PyObject_IsTrue(value.ptr()) == 1;
    refuse_type(place, "True or False", value);
}

std::string text(py::handle value, const Place& place)
{
    if (!PyUnicode_Check(value.ptr())) refuse_type(place, "a str", value);
    Py_ssize_t size = 0;
    if (const char* const bytes = PyUnicode_AsUTF8AndSize(value.ptr(), &size))
        return {bytes, static_cast<std::size_t>(size)};
    PyErr_Clear();
    refuse_value(place, "holds a lone surrogate, which is not a character");
}

std::string path(py::handle value, const Place& place)
{
    PyObject* bytes = nullptr;
    if (!PyUnicode_FSConverter(value.ptr(), &bytes)) {
        const bool type = PyErr_ExceptionMatches(PyExc_TypeError);
        PyErr_Clear();
        if (type) refuse_type(place, "a path (str, bytes or os.PathLike)", value);
        refuse_value(place, "a path cannot hold a null character");
    }
    return py::reinterpret_steal<py::bytes>(bytes);
}

py::array doubles(py::handle value, const Place& place)
{
    return numbers<double, 'f', 'i', 'u'>(value, place, "an array of numbers");
}

py::array whole_numbers(py::handle value, const Place& place)
{
    // Unsigned 64-bit numbers may exceed the signed range.
    if (py::isinstance<py::array>(value) && py::reinterpret_borrow<py::array>(value).dtype().kind() == 'u')
        return numbers<std::uint64_t, 'u'>(value, place, "an array of whole numbers");
    return numbers<std::int64_t, 'i', 'u'>(value, place, "an array of whole numbers");
}

bool has_shape(const py::array& array, std::initializer_list<py::ssize_t> shape)
{
    if (array.ndim() != static_cast<py::ssize_t>(shape.size())) return false;
    py::ssize_t axis = 0;
    for (const py::ssize_t length : shape)
        if (array.shape(axis++) != length && length >= 0) return false;
    return true;
}

std::string shape_of(const py::array& array)
{
    return text_of(array.attr("shape"));
}

Eigen::Vector3d vector3(py::handle value, const Place& place)
{
    const py::array array = doubles(value, place);
    if (!has_shape(array, {3})) refuse_value(place, "expected shape (3,), got " + shape_of(array));
    return Eigen::Map<const Eigen::Vector3d>(static_cast<const double*>(array.data()));
}

Eigen::Vector2d vector2(py::handle value, const Place& place)
{
    const py::array array = doubles(value, place);
    const auto* at = static_cast<const double*>(array.data());
    if (array.ndim() == 0) return {at[0], at[0]};
    if (!has_shape(array, {2})) refuse_value(place, "expected a number or shape (2,), got " + shape_of(array));
    return {at[0], at[1]};
}

std::vector<Eigen::Vector3d> points(py::handle value, const Place& place)
{
    const py::array array = doubles(value, place);
    if (!has_shape(array, {-1, 3})) refuse_value(place, "expected shape (N, 3), got " + shape_of(array));
    std::vector<Eigen::Vector3d> made(static_cast<std::size_t>(array.shape(0)));
    const auto* at = static_cast<const double*>(array.data());
    for (Eigen::Vector3d& point : made) point = Eigen::Vector3d(at), at += 3;
    return made;
}

Points::Points(py::handle value, const Place& place)
    : array_(doubles(value, place)), at_(static_cast<const double*>(array_.data())),
      size_(static_cast<std::size_t>(array_.size()) / 3), one_(array_.ndim() == 1)
{
    if (!has_shape(array_, {3}) && !has_shape(array_, {-1, 3}))
        refuse_value(place, "expected shape (3,) or (N, 3), got " + shape_of(array_));
}

Eigen::Isometry3d pose(py::handle value, const Place& place)
{
    return Poses(value, place, false)[0];
}

Poses::Poses(py::handle value, const Place& place, bool may_be_many)
{
    if (value.is_none()) {
        made_ = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
        rows_ = made_;
        return;
    }
    const py::array array = doubles(value, place);
    kept_ = array;
    const bool matrices = has_shape(array, {4, 4}) || (may_be_many && has_shape(array, {-1, 4, 4}));
    if (!matrices && !has_shape(array, {7}) && !(may_be_many && has_shape(array, {-1, 7})))
        refuse_value(place, fmt::format("expected shape {}, or {} with x y z qx qy qz qw{}, got {}",
                                        may_be_many ? "(N, 4, 4)" : "(4, 4)", may_be_many ? "(N, 7)" : "(7,)",
                                        may_be_many ? ", or one pose for all" : "", shape_of(array)));
    one_ = array.ndim() == (matrices ? 2 : 1);
    const auto* at = static_cast<const double*>(array.data());
    const auto size = static_cast<std::size_t>(array.size());
    if (matrices) {
        rows_ = {at, size};
        return;
    }
    made_.resize(size / 7 * 16);
    for (std::size_t i = 0; i < size / 7; ++i) write_rows(at + 7 * i, made_.data() + 16 * i, place);
    rows_ = made_;
}

Eigen::Isometry3d Poses::operator[](std::size_t i) const
{
    return of_rows(rows_.data() + (one_ ? 0 : 16 * i));
}

namespace {

BodyId id_of(std::uint64_t id)
{
    return {static_cast<std::uint32_t>(id), static_cast<std::uint16_t>(id >> 32), static_cast<std::uint16_t>(id >> 48)};
}

} // namespace

BodyId body(py::handle value, const Place& place)
{
    return id_of(whole(value, place, ~std::uint64_t{0}));
}

bool is_many(py::handle value)
{
    if (py::isinstance<py::array>(value)) return py::reinterpret_borrow<py::array>(value).ndim() > 0;
    if (PyIndex_Check(value.ptr()) || PyUnicode_Check(value.ptr())) return false;
    return PySequence_Check(value.ptr()) || py::hasattr(value, "__array__");
}

Ids::Ids(py::handle value, const Place& place) : one_(PyLong_CheckExact(value.ptr()) || !is_many(value))
{
    if (one_) {
        single_ = body(value, place);
        ids_ = {&single_, 1};
        return;
    }
    if (!py::isinstance<py::array>(value)) { // NumPy makes floats of int and uint64
        const auto items = py::reinterpret_borrow<py::sequence>(value);
        const auto is_whole = [](py::handle item) { return PyIndex_Check(item.ptr()) && !PyBool_Check(item.ptr()); };
        if (PySequence_Check(value.ptr()) && std::all_of(items.begin(), items.end(), is_whole)) {
            for (py::handle item : items) made_.push_back(body(item, place));
            ids_ = made_;
            return;
        }
    }
    const py::array array = whole_numbers(value, place);
    if (array.ndim() != 1) refuse_value(place, "expected shape (N,), got " + shape_of(array));
    static_assert(sizeof(BodyId) == 8); // a negative number becomes an id that no body has
    ids_ = {static_cast<const BodyId*>(array.data()), static_cast<std::size_t>(array.shape(0))};
    kept_ = array;
}

py::array ids_of(std::span<const BodyId> bodies)
{
    return py::array(py::dtype("u8"), static_cast<py::ssize_t>(bodies.size()), bodies.data());
}

void Lengths::add(const char* argument, bool one, std::size_t entries)
{
    if (one) return;
    if (!one_ && entries != size_)
        refuse_value({call_, argument}, fmt::format("{} entries, but an earlier argument has {}; must be as many, or "
                                                    "one for all",
                                                    entries, size_));
    one_ = false, size_ = entries;
}

py::array offsets_of(std::span<const std::size_t> offsets)
{
    py::array_t<std::int64_t> made(static_cast<py::ssize_t>(offsets.size()));
    std::copy(offsets.begin(), offsets.end(), made.mutable_data());
    return made;
}

} // namespace oncollide::python
