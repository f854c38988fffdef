// Keyword arguments of World and Queries.
#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "bindings.hpp"

#include <oncollide/base/printable.hpp>

namespace oncollide::python {

namespace {

struct Setting {
    const char* name;
    void (*set)(Settings&, py::handle value, const Place& place);
};

template <auto from_name>
auto by_name(py::handle value, const Place& place)
{
    const std::string name = text(value, place);
    try {
        return from_name(name);
    } catch (const Error& error) { // "exact: no 'x'; valid: ..."
        const std::string what = error.what();
        refuse_value(place, what.substr(what.find(": ") + 2));
    }
}

int whole_int(py::handle value, const Place& place)
{
    return static_cast<int>(whole(value, place, 0x7fffffff));
}

constexpr std::array known_settings{
    Setting{"max_error", [](Settings& s, py::handle v, const Place& p) { s.max_error = number(v, p); }},
    Setting{"depth", [](Settings& s, py::handle v, const Place& p) { s.depth = whole_int(v, p); }},
    Setting{"clearance", [](Settings& s, py::handle v, const Place& p) { s.clearance = number(v, p); }},
    Setting{"exact", [](Settings& s, py::handle v, const Place& p) { s.exact = by_name<exact_from_name>(v, p); }},
    Setting{"contact_kinds", [](Settings& s, py::handle v, const Place& p) { s.contact_kinds = truth(v, p); }},
    Setting{"ignore_touching", [](Settings& s, py::handle v, const Place& p) { s.ignore_touching = truth(v, p); }},
    Setting{"mode", [](Settings& s, py::handle v, const Place& p) { s.mode = by_name<mode_from_name>(v, p); }},
    Setting{"open_as_surface", [](Settings& s, py::handle v, const Place& p) { s.open_as_surface = truth(v, p); }},
    Setting{"backend", [](Settings& s, py::handle v, const Place& p) { s.backend = by_name<backend_from_name>(v, p); }},
    Setting{"bounding_volume", [](Settings& s, py::handle v,
                                  const Place& p) { s.bounding_volume = by_name<bounding_volume_from_name>(v, p); }},
    Setting{"gpu", [](Settings& s, py::handle v, const Place& p) { s.gpu = whole_int(v, p); }},
    Setting{"viewport", [](Settings& s, py::handle v, const Place& p) { s.viewport = whole_int(v, p); }},
    Setting{"broad_phase",
            [](Settings& s, py::handle v, const Place& p) { s.broad_phase = by_name<broad_phase_from_name>(v, p); }},
    Setting{"threads", [](Settings& s, py::handle v, const Place& p) { s.threads = whole_int(v, p); }},
    Setting{"skip",
            [](Settings& s, py::handle v, const Place& p) {
                if (PyUnicode_Check(v.ptr()) || !py::isinstance<py::iterable>(v))
                    refuse_type(p, "a list of names of stages", v);
                for (py::handle name : py::reinterpret_borrow<py::iterable>(v))
                    s.skip.insert(by_name<stage_from_name>(name, p));
            }},
    Setting{"age_limit", [](Settings& s, py::handle v, const Place& p) { s.age_limit = whole_int(v, p); }},
    Setting{"node_budget", [](Settings& s, py::handle v, const Place& p) { s.node_budget = whole(v, p, ~0ull); }},
    Setting{"memory_budget", [](Settings& s, py::handle v, const Place& p) { s.memory_budget = whole(v, p, ~0ull); }},
    Setting{"resident_budget",
            [](Settings& s, py::handle v, const Place& p) { s.resident_budget = whole(v, p, ~0ull); }},
    Setting{"look_ahead", [](Settings& s, py::handle v, const Place& p) { s.look_ahead = whole_int(v, p); }},
    Setting{"coherence", [](Settings& s, py::handle v, const Place& p) { s.coherence = truth(v, p); }},
};

} // namespace

Settings settings_of(const py::kwargs& arguments, const char* call)
{
    Settings made;
    for (const auto& [key, value] : arguments) {
        const std::string name = text(key, {call, "the name of a setting"});
        const auto* const found = std::find_if(known_settings.begin(), known_settings.end(),
                                               [&](const Setting& s) { return name == s.name; });
        if (found == known_settings.end()) {
            std::string names;
            for (const Setting& s : known_settings) names += fmt::format("{}{}", names.empty() ? "" : ", ", s.name);
            throw py::type_error(fmt::format("{}: no setting '{}'; valid: {}", call, printable(name), names));
        }
        if (!value.is_none()) found->set(made, value, {call, found->name}); // None: the default
    }
    return made;
}

} // namespace oncollide::python
