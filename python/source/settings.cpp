// Settings as keyword arguments.
#include <fmt/format.h>

#include "bindings.hpp"

#include <oncollide/base/text/printable.hpp>
#include <oncollide/pipeline/settings_table.hpp>

namespace oncollide::python {

namespace {

nlohmann::json names_in(py::handle value, const Place& place)
{
    if (PyUnicode_Check(value.ptr()) || !py::isinstance<py::iterable>(value))
        refuse_type(place, "a list of names of stages", value);
    nlohmann::json names = nlohmann::json::array();
    for (py::handle name : py::reinterpret_borrow<py::iterable>(value)) names.push_back(text(name, place));
    return names;
}

nlohmann::json value_of(SettingForm form, py::handle value, const Place& place)
{
    switch (form) {
    case SettingForm::flag:
        return truth(value, place);
    case SettingForm::whole:
        return whole(value, place, 0x7fffffff);
    case SettingForm::amount:
        return whole(value, place, ~std::uint64_t{0});
    case SettingForm::length:
        return number(value, place);
    case SettingForm::name:
        return text(value, place);
    case SettingForm::names:
        return names_in(value, place);
    }
    return {};
}

void set(Settings& settings, const SettingRow& row, py::handle value, const Place& place)
{
    const nlohmann::json given = value_of(row.form, value, place);
    try {
        row.set(settings, given);
    } catch (const Error& error) { // "exact: no 'x'; valid: ..."
        const std::string what = error.what();
        refuse_value(place, what.substr(what.find(": ") + 2));
    }
}

} // namespace

Settings settings_of(const py::kwargs& arguments, const char* call)
{
    Settings made;
    for (const auto& [key, value] : arguments) {
        const std::string name = text(key, {call, "the name of a setting"});
        const SettingRow* const row = setting_of(name);
        if (!row) {
            std::string names;
            for (const SettingRow& r : settings_table())
                names += fmt::format("{}{}", names.empty() ? "" : ", ", r.member);
            throw py::type_error(fmt::format("{}: no setting '{}'; valid: {}", call, printable(name), names));
        }
        if (!value.is_none()) set(made, *row, value, {call, row->member.data()}); // None: the default
    }
    return made;
}

py::dict dict_of(const Settings& settings)
{
    const py::object read = py::module_::import("json").attr("loads");
    py::dict made;
    for (const SettingRow& row : settings_table()) {
        py::object value = read(row.get(settings));
        if (row.form == SettingForm::length && !value.is_none()) value = py::float_(value);
        if (row.form == SettingForm::whole && value.equal(py::int_(-1))) value = py::none(); // the default
        made[py::str(std::string(row.member))] = value;
    }
    return made;
}

std::string settings_text()
{
    std::string text;
    for (const SettingRow& row : settings_table()) {
        const char* const when = row.form != SettingForm::flag ? "" : row.option_clears() ? "False: " : "True: ";
        text += fmt::format("  {}: {}{}", row.member, when, row.help);
        if (row.form == SettingForm::name || row.form == SettingForm::names) text += fmt::format("; {}", row.value);
        text += row.by_default.empty() ? "\n" : fmt::format(" (default {})\n", row.by_default);
    }
    return text;
}

} // namespace oncollide::python
