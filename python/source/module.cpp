#include "bindings.hpp"
#include "release.hpp"

namespace oncollide::python {

namespace {

const char* name_of(ErrorKind kind)
{
    switch (kind) {
    case ErrorKind::usage:
        return "usage";
    case ErrorKind::bad_data:
        return "bad_data";
    case ErrorKind::no_input:
        return "no_input";
    case ErrorKind::no_gpu:
        return "no_gpu";
    case ErrorKind::cannot_write:
        return "cannot_write";
    default:
        return "internal";
    }
}

void bind_error(py::module_& m)
{
    static PyObject* type = nullptr; // static, because the translator captures nothing
    type = PyErr_NewExceptionWithDoc("oncollide.Error", R"(An error of the library; the message is one line.

kind: 'usage' (a request that is invalid or not supported), 'bad_data' (an array or a file is not valid), 'no_input' (a
file is missing or unreadable), 'no_gpu', 'cannot_write' or 'internal'.)",
                                     PyExc_Exception, nullptr);
    if (!type) throw py::error_already_set();
    m.add_object("Error", py::reinterpret_borrow<py::object>(type));
    py::register_exception_translator([](std::exception_ptr thrown) {
        try {
            if (thrown) std::rethrow_exception(thrown);
        } catch (const Error& error) {
            const py::object made = py::reinterpret_borrow<py::object>(type)(py::str(error.what()));
            made.attr("kind") = name_of(error.kind());
            PyErr_SetObject(type, made.ptr());
        }
    });
}

} // namespace

} // namespace oncollide::python

PYBIND11_MODULE(_core, m)
{
    using namespace oncollide::python;
    py::options options;
    options.disable_function_signatures(); // docstrings begin with signatures that inspect understands
    make_result_types();
    bind_error(m);
    bind_geometry(m);
    bind_shapes(m);
    bind_grids(m);
    bind_two_geometries(m);
    bind_world(m);
    bind_robot(m);
    interpreter_begins();
    py::module_::import("atexit").attr("register")(py::cpp_function(&interpreter_ends));
}
