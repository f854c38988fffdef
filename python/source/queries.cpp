// Queries: many pairs at many poses, from arrays.
#include <optional>

#include <fmt/format.h>

#include <oncollide/pipeline/two_geometries.hpp>

#include "bindings.hpp"
#include "release.hpp"

namespace oncollide::python {

namespace {

struct HeldQueries {
    using InModule = void;
    Interrupts interrupts;
    MeshQueries queries;
    Users users;

    HeldQueries(std::vector<GeometryHandle> geometries, const Settings& settings)
        : queries(std::move(geometries), with_stop(settings))
    {
    }
    Settings with_stop(Settings settings)
    {
        settings.stop = [this] { return interrupts.requested(); };
        return settings;
    }
};

/// The geometry index of each query: one for all, or an array; uses the array's own memory if it is of uint32.
class Numbers {
public:
    Numbers(py::handle value, const Place& place, std::size_t count)
    {
        const auto check = [&](std::int64_t number) {
            if (number < 0 || static_cast<std::uint64_t>(number) >= count)
                refuse_value(place, fmt::format("there is no geometry {}; these Queries have {}, numbered from 0",
                                                number, count));
            return static_cast<std::uint32_t>(number);
        };
        using Wanted = py::array_t<std::uint32_t, py::array::c_style>;
        if (Wanted::check_(value)) {
            array_ = py::reinterpret_borrow<py::array>(value);
            numbers_ = {static_cast<const std::uint32_t*>(array_.data()), static_cast<std::size_t>(array_.size())};
        } else if (PyLong_CheckExact(value.ptr())) {
            single_ = check(PyLong_AsLongLong(value.ptr()));
            if (PyErr_Occurred()) PyErr_Clear();
            numbers_ = {&single_, 1};
            return;
        } else {
            array_ = whole_numbers(value, place);
            const std::span given(static_cast<const std::int64_t*>(array_.data()),
                                  static_cast<std::size_t>(array_.size()));
            made_.reserve(given.size());
            for (const std::int64_t number : given) made_.push_back(check(number));
            numbers_ = made_;
        }
        if (array_.ndim() > 1) refuse_value(place, "expected a number or shape (N,), got " + shape_of(array_));
        one_ = array_.ndim() == 0;
        for (const std::uint32_t number : numbers_) // before any lock is released
            if (number >= count) check(number);
    }
    Numbers(const Numbers&) = delete;

    bool one() const { return one_; }
    std::span<const std::uint32_t> all() const { return numbers_; }

private:
    py::array array_;
    std::vector<std::uint32_t> made_;
    std::span<const std::uint32_t> numbers_;
    std::uint32_t single_ = 0;
    bool one_ = true;
};

/// The arguments of one call as columns.
class Columns {
public:
    Columns(const HeldQueries& held, const char* call, py::handle a, py::handle b, py::handle poses_a,
            py::handle poses_b)
        : a_(a, {call, "a"}, held.queries.size()), b_(b, {call, "b"}, held.queries.size()),
          poses_a_(poses_a, {call, "poses_a"}), poses_b_(poses_b, {call, "poses_b"})
    {
        std::optional<std::size_t> length;
        const auto take = [&](const char* argument, bool one, std::size_t entries) {
            if (one) return;
            if (length && *length != entries)
                refuse_value({call, argument}, fmt::format("{} entries, but an earlier argument has {}; must be as "
                                                           "many, or one for all",
                                                           entries, *length));
            length = entries;
        };
        take("a", a_.one(), a_.all().size()), take("b", b_.one(), b_.all().size());
        take("poses_a", poses_a_.one(), poses_a_.size()), take("poses_b", poses_b_.one(), poses_b_.size());
        size_ = length.value_or(1);
    }
    std::size_t size() const { return size_; }
    MeshQueryColumns columns() const { return {a_.all(), b_.all(), poses_a_.rows(), poses_b_.rows()}; }

private:
    Numbers a_, b_;
    Poses poses_a_, poses_b_;
    std::size_t size_ = 0;
};

py::tuple run(HeldQueries& held, py::handle a, py::handle b, py::handle poses_a, py::handle poses_b)
{
    const Columns columns(held, "Queries.run", a, b, poses_a, poses_b);
    const auto size = static_cast<py::ssize_t>(columns.size());
    py::array_t<std::uint8_t> verdicts(size);
    py::array_t<double> bounds(size);
    {
        const std::span verdict(reinterpret_cast<Verdict*>(verdicts.mutable_data()), columns.size());
        const std::span bound(bounds.mutable_data(), columns.size());
        const Users::Alone alone(held.users, "Queries.run");
        const Released released(&held.interrupts);
        held.queries.run(columns.columns(), verdict, bound);
    }
    held.interrupts.rethrow();
    return py::make_tuple(verdicts, bounds);
}

py::array distances(HeldQueries& held, py::handle a, py::handle b, py::handle poses_a, py::handle poses_b,
                    py::handle tolerance, py::handle farthest, py::handle cutoff)
{
    const char* const call = "Queries.distances";
    const Columns columns(held, call, a, b, poses_a, poses_b);
    const double within = number(tolerance, {call, "tolerance"});
    const double limit =
        farthest.is_none() ? limit_of(cutoff, {call, "cutoff"}) : limit_of(farthest, {call, "farthest"});
    std::vector<Distance> found;
    {
        const Users::Alone alone(held.users, call);
        const Released released(&held.interrupts);
        found.resize(columns.size());
        held.queries.distances(columns.columns(), within, found, limit);
    }
    held.interrupts.rethrow();
    return array_of(result_types().distance, std::move(found));
}

} // namespace

void bind_queries(py::module_& m)
{
    using namespace py::literals;
    py::class_<HeldQueries> queries(m, "Queries", R"(Queries(geometries, **settings)
--

Tests many pairs at many poses, without bodies: for planners that sample poses.

    queries = oncollide.Queries([robot, house], threads=0)
    verdict, bound = queries.run(0, 1, robot_poses, np.eye(4))

geometries: a sequence of Geometry, of any kind; queries use their indices. settings: World's max_error, depth,
clearance, exact ('auto', 'off' or 'predicates'), bounding_volume, threads, age_limit (in calls) and the budgets. Trees grow
where queries need them, and are kept from call to call. One thread at a time; a call uses `threads` threads.)");
    refuse_pickles(queries, "Queries", "make them in each process, of geometries, which can be pickled");
    queries
        .def(py::init([](py::handle geometries, const py::kwargs& settings) {
                 const Place place{"Queries", "geometries"};
                 if (!py::isinstance<py::sequence>(geometries))
                     refuse_type(place, "a sequence of Geometry", geometries);
                 std::vector<GeometryHandle> all;
                 for (const py::handle item : py::reinterpret_borrow<py::sequence>(geometries))
                     all.push_back(geometry(item, place));
                 return std::make_unique<HeldQueries>(std::move(all), settings_of(settings, "Queries"));
             }),
             "geometries"_a)
        .def("run", &run, "a"_a, "b"_a, "poses_a"_a, "poses_b"_a, R"(run(self, a, b, poses_a, poses_b)
--

Decides whether geometries a and b collide at these poses.

a, b: whole numbers (N,), or one for all. poses_a, poses_b: (N, 4, 4) or (N, 7), metres, or one pose for all. Arrays of
poses are not copied if they are (N, 4, 4), C-contiguous and float64; a and b are not copied if they are uint32.
Returns (verdict, bound): uint8 (N,), a Verdict each, and float64 (N,), metres, as in Frame.pairs. They are independent
of the thread count and of the other queries in the batch. Other Python threads can run meanwhile; Ctrl-C ends it soon.
Raises ValueError for other shapes and lengths, Error naming the query whose pose is not rigid.)")
        .def("distances", &distances, "a"_a, "b"_a, "poses_a"_a, "poses_b"_a, "tolerance"_a = 0.0,
             "farthest"_a = py::none(), "cutoff"_a = py::none(),
             R"(distances(self, a, b, poses_a, poses_b, tolerance=0.0, farthest=None, cutoff=None)
--

Distances. Arguments as in run(); result, tolerance and cutoff as in World.pairs().distance(), structured (N,). farthest: the older
name of cutoff.)")
        .def(
            "__len__", [](const HeldQueries& held) { return held.queries.size(); }, R"(__len__(self, /)
--

Number of geometries.)")
        .def_property_readonly(
            "bytes",
            [](HeldQueries& held) {
                const Users::Beside beside(held.users, "Queries.bytes");
                return held.queries.bytes();
            },
            "Memory of the trees, bytes (int).");
}

} // namespace oncollide::python
