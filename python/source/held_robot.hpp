#pragma once
#include <memory>
#include <span>

#include <oncollide/robots/robot.hpp>

#include "held_world.hpp"

namespace oncollide::python {

struct HeldRobot {
    using InModule = void;
    std::shared_ptr<HeldWorld> held;
    std::unique_ptr<Robot> robot;
};

/// Rows of a configuration's width, or one.
py::array rows_of(const HeldRobot& robot, py::handle value, const Place& place);
std::span<const double> span_of(const py::array& array);

/// A link by its name or its number, which Robot checks.
std::uint32_t link_of(const HeldRobot& robot, py::handle value, const Place& place);

void bind_robot_setup(py::class_<HeldRobot>& robot);

} // namespace oncollide::python
