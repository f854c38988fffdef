#include "robot/sphere_files.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/csv_reader.hpp>
#include <oncollide/base/text/csv_writer.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/base/text/listed.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide::tools {

namespace {

constexpr std::uintmax_t most_bytes = std::uintmax_t{64} << 20;

SphereModel read_urdf_spheres(const std::string& path, const RobotDescription& robot,
                              std::vector<std::string>& warnings)
{
    SphereModel model(robot.links.size());
    for (const RobotLink& link : load_robot(path).links) {
        if (link.collision.empty()) continue;
        const int i = link_named(link.name, robot, warnings);
        for (const LinkGeometry& collision : link.collision) {
            const Shape* const shape = std::get_if<Shape>(&collision.geometry->data);
            const Sphere* const sphere = shape ? std::get_if<Sphere>(shape) : nullptr;
            if (!sphere)
                refuse(path, fmt::format("link '{}': a collision geometry is no sphere", printable(link.name)));
            if (i >= 0) model[static_cast<std::size_t>(i)].push_back({collision.pose.translation(), sphere->radius});
        }
    }
    return model;
}

SphereModel read_csv_spheres(const std::string& path, const RobotDescription& robot, std::vector<std::string>& warnings)
{
    const std::string text = read_file(path, most_bytes);
    SphereModel model(robot.links.size());
    CsvReader csv(path, text, CsvReader::Style::list);
    for (bool header = true; !csv.at_end(); csv.next_line()) {
        std::vector<std::string> fields;
        for (bool last = false; !last;) fields.emplace_back(csv.next(last));
        if (fields.size() == 1 && fields[0].empty()) continue;
        if (std::exchange(header, false)) {
            if (fields != std::vector<std::string>{"link", "x", "y", "z", "radius"})
                csv.fail("the first line must be link,x,y,z,radius");
            continue;
        }
        if (fields.size() != 5) csv.fail(fmt::format("{} fields; there must be 5", fields.size()));
        double n[4];
        for (std::size_t k = 0; k < 4; ++k)
            if (!parse(fields[k + 1], n[k]) || !std::isfinite(n[k]))
                csv.fail(oncollide::quoted(fields[k + 1]) + " is not a finite number");
        if (const int i = link_named(std::string(csv_text(fields[0])), robot, warnings); i >= 0 && n[3] > 0)
            model[static_cast<std::size_t>(i)].push_back({{n[0], n[1], n[2]}, n[3]});
    }
    return model;
}

std::string xml_text(std::string_view text)
{
    std::string escaped;
    for (const char c : text) {
        if (c == '&')
            escaped += "&amp;";
        else if (c == '<')
            escaped += "&lt;";
        else if (c == '"')
            escaped += "&quot;";
        else
            escaped += c;
    }
    return escaped;
}

} // namespace

std::size_t count_of(const SphereModel& model)
{
    std::size_t count = 0;
    for (const auto& spheres : model) count += spheres.size();
    return count;
}

int link_named(const std::string& name, const RobotDescription& robot, std::vector<std::string>& warnings)
{
    const auto found = std::ranges::find(robot.links, name, &RobotLink::name);
    if (found != robot.links.end()) return static_cast<int>(found - robot.links.begin());
    const std::string warning =
        fmt::format("the robot has no link '{}'; its spheres are left out", shortened(printable(name)));
    if (!std::ranges::count(warnings, warning)) warnings.push_back(warning);
    return -1;
}

SphereModel load_sphere_model(const std::string& path, const RobotDescription& robot,
                              std::vector<std::string>& warnings)
{
    const std::string kind = lower_extension(path);
    SphereModel model;
    if (kind == ".urdf")
        model = read_urdf_spheres(path, robot, warnings);
    else if (kind == ".csv")
        model = read_csv_spheres(path, robot, warnings);
    else if (kind == ".yml" || kind == ".yaml")
        model = read_yaml_spheres(path, robot, warnings);
    else
        throw Error(ErrorKind::usage,
                    fmt::format("{}: unknown kind of sphere model '{}'; known are .yml, .yaml, .urdf, .csv",
                                printable(path), printable(kind)));
    if (count_of(model) == 0) refuse(path, "holds no sphere of a link of this robot");
    return model;
}

void save_yaml_spheres(const std::string& path, const RobotDescription& robot, const SphereModel& model)
{
    OutputFile file(path);
    file.write("collision_spheres:\n");
    for (std::size_t i = 0; i < model.size(); ++i) {
        if (model[i].empty()) continue;
        file.write(fmt::format("  {}:\n", json_string(robot.links[i].name))); // JSON's strings are YAML's
        for (const CoverSphere& s : model[i])
            file.write(fmt::format("    - \"center\": [{}, {}, {}]\n      \"radius\": {}\n", s.centre.x(), s.centre.y(),
                                   s.centre.z(), s.radius));
    }
    file.commit();
}

void save_csv_spheres(const std::string& path, const RobotDescription& robot, const SphereModel& model)
{
    OutputFile file(path);
    CsvWriter csv(file, "link,x,y,z,radius");
    for (std::size_t i = 0; i < model.size(); ++i)
        for (const CoverSphere& s : model[i])
            csv.row(Quoted{robot.links[i].name}, s.centre.x(), s.centre.y(), s.centre.z(), s.radius);
    file.commit();
}

void save_urdf_spheres(const std::string& path, const RobotDescription& robot, const SphereModel& model)
{
    OutputFile file(path);
    file.write(fmt::format("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", xml_text(robot.name)));
    for (std::size_t i = 0; i < model.size(); ++i) {
        file.write(fmt::format("  <link name=\"{}\">\n", xml_text(robot.links[i].name)));
        for (const CoverSphere& s : model[i])
            file.write(fmt::format("    <collision><origin xyz=\"{} {} {}\" rpy=\"0 0 0\"/>"
                                   "<geometry><sphere radius=\"{}\"/></geometry></collision>\n",
                                   s.centre.x(), s.centre.y(), s.centre.z(), s.radius));
        file.write("  </link>\n");
    }
    for (const RobotJoint& joint : robot.joints) {
        const Eigen::Vector3d at = joint.origin.translation(), angles = joint.origin.linear().eulerAngles(2, 1, 0);
        file.write(fmt::format("  <joint name=\"{}\" type=\"{}\">\n    <parent link=\"{}\"/><child link=\"{}\"/>\n"
                               "    <origin xyz=\"{:.17g} {:.17g} {:.17g}\" rpy=\"{:.17g} {:.17g} {:.17g}\"/>\n"
                               "    <axis xyz=\"{:.17g} {:.17g} {:.17g}\"/>\n",
                               xml_text(joint.name), name_of(joint.kind), xml_text(robot.links[joint.parent].name),
                               xml_text(robot.links[joint.child].name), at.x(), at.y(), at.z(), angles[2], angles[1],
                               angles[0], joint.axis.x(), joint.axis.y(), joint.axis.z()));
        if (joint.kind == JointKind::revolute || joint.kind == JointKind::prismatic)
            file.write(fmt::format("    <limit lower=\"{:.17g}\" upper=\"{:.17g}\" effort=\"0\" velocity=\"0\"/>\n",
                                   joint.lower, joint.upper));
        if (joint.mimics >= 0)
            file.write(fmt::format("    <mimic joint=\"{}\" multiplier=\"{:.17g}\" offset=\"{:.17g}\"/>\n",
                                   xml_text(robot.joints[static_cast<std::size_t>(joint.mimics)].name),
                                   joint.multiplier, joint.offset));
        file.write("  </joint>\n");
    }
    file.write("</robot>\n");
    file.commit();
}

} // namespace oncollide::tools
