#include <oncollide/robots/files/robot_reader.hpp>

#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/program_output.hpp>
#include <oncollide/base/text/file_warning.hpp>
#include <oncollide/base/text/near_word.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/robots/description_fault.hpp>
#include <oncollide/scenes/files/xml/xml_reader.hpp>

namespace oncollide {

namespace {

constexpr std::uintmax_t most_bytes = std::uintmax_t{64} << 20;

/// The name of a file's outermost element; empty if it is far from the beginning.
std::string outermost_element(const MeshSource& source)
{
    struct First : XmlHandler {
        void begin(const XmlTag& tag) override
        {
            if (name.empty()) name = tag.name;
        }
        void end() override {}
        std::string name{};
    } first;
    XmlReader(source, first).read(source.bytes.substr(0, std::size_t{1} << 14));
    return first.name;
}

/// Whether the program xacro has to expand a file before it is URDF.
bool is_for_xacro(const std::filesystem::path& file, std::string_view bytes)
{
    return lower_extension(file) == ".xacro" || bytes.find("<xacro:") != bytes.npos;
}

/// The last lines that a program wrote.
std::string last_of(std::string text)
{
    constexpr std::size_t most = 600;
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    if (text.size() > most) text = "..." + text.substr(text.size() - most);
    std::ranges::replace(text, '\n', ' ');
    return printable(text);
}

/// The URDF that the program xacro makes of a file.
std::string expand_xacro(const std::filesystem::path& program, const std::filesystem::path& file)
{
    using End = ProgramOutput::End;
    const ProgramLimits limits{.bytes = most_bytes};
    ProgramOutput made = output_of(program, {absolute_path(file).string()}, limits);
    const std::string said = last_of(std::move(made.errors));
    if (made.is_good() && !made.output.empty()) {
        if (!said.empty()) warn_of_file(file.string(), "xacro: " + said);
        return std::move(made.output);
    }
    const std::string how = made.end == End::too_long
                                ? fmt::format("was stopped after {} s", limits.time.count() / 1000)
                            : made.end == End::too_much ? fmt::format("wrote more than {} MB", most_bytes >> 20)
                            : made.end == End::killed   ? fmt::format("was killed by signal {}", made.code)
                            : made.code                 ? fmt::format("failed with exit code {}", made.code)
                                                        : "wrote nothing";
    refuse(file.string(), fmt::format("{} {}{}{}", program.string(), how, said.empty() ? "" : ": ", said));
}

} // namespace

void RobotSource::fail_at(const XmlElement& element, const std::string& what) const
{
    const std::string& own = element.attribute("name");
    const MeshSource in{element.file ? included[element.file - 1] : name, {}};
    in.fail(fmt::format("{}{}: {}", printable(element.name),
                        own.empty() ? "" : fmt::format(" {}", oncollide::quoted(own)), what),
            element.line);
}

void RobotSource::check(const RobotDescription& robot, std::span<const XmlElement* const> links,
                        std::span<const XmlElement* const> joints, const XmlElement& root) const
{
    using Of = DescriptionFault::Of;
    const std::optional<DescriptionFault> fault = fault_of(robot);
    if (!fault) return;
    fail_at(fault->of == Of::link    ? *links[fault->number]
            : fault->of == Of::joint ? *joints[fault->number]
                                     : root,
            fault->what);
}

const std::string& RobotSource::required(const XmlElement& element, std::string_view key) const
{
    const std::string& text = element.attribute(key);
    if (text.empty()) fail_at(element, fmt::format("has no attribute '{}'", key));
    return text;
}

std::optional<std::vector<double>> RobotSource::numbers(const XmlElement& element, std::string_view key) const
{
    if (std::ranges::find(element.attributes, key, &std::pair<std::string, std::string>::first) ==
        element.attributes.end())
        return {};
    const std::string& text = element.attribute(key);
    if (text.find("${") != text.npos || text.find("$(") != text.npos)
        fail_at(element, fmt::format("{} is {}, an expression for xacro; expand the file first: xacro {} > robot.urdf",
                                     key, oncollide::quoted(text), name));
    std::vector<double> numbers;
    for (std::size_t at = 0; (at = text.find_first_not_of(" \t\r\n", at)) != text.npos;) {
        const std::size_t end = std::min(text.find_first_of(" \t\r\n", at), text.size());
        const std::string_view word = std::string_view(text).substr(at, end - at);
        if (double value = 0; parse(word, value) && std::isfinite(value))
            numbers.push_back(value);
        else
            fail_at(element, fmt::format("{}: {} is not a finite number", key, oncollide::quoted(word)));
        at = end;
    }
    return numbers;
}

std::optional<std::vector<double>> RobotSource::numbers(const XmlElement& element, std::string_view key,
                                                        std::size_t count) const
{
    auto found = numbers(element, key);
    if (found && found->size() != count)
        fail_at(element, fmt::format("{} has {} number{}; it must have {}", key, found->size(),
                                     found->size() == 1 ? "" : "s", count));
    return found;
}

double RobotSource::number(const XmlElement& element, std::string_view key) const
{
    required(element, key);
    return numbers(element, key, 1)->front();
}

double RobotSource::number(const XmlElement& element, std::string_view key, double without) const
{
    const auto found = numbers(element, key, 1);
    return found ? found->front() : without;
}

Eigen::Vector3d RobotSource::vector(const XmlElement& element, std::string_view key,
                                    const Eigen::Vector3d& without) const
{
    const auto found = numbers(element, key, 3);
    return found ? Eigen::Vector3d(found->data()) : without;
}

template <class Named>
std::uint32_t find_named(const RobotSource& source, const XmlElement& element, const char* what, std::string_view name,
                         const std::vector<Named>& named)
{
    const auto found = std::ranges::find(named, name, &Named::name);
    if (found != named.end()) return static_cast<std::uint32_t>(found - named.begin());
    const std::vector<std::string_view> names = [&] {
        std::vector<std::string_view> list;
        for (const Named& one : named) list.push_back(one.name);
        return list;
    }();
    source.fail_at(element, fmt::format("the robot has no {} {}{}", what, oncollide::quoted(name),
                                        printable(did_you_mean(name, names))));
}
template std::uint32_t find_named(const RobotSource&, const XmlElement&, const char*, std::string_view,
                                  const std::vector<RobotLink>&);
template std::uint32_t find_named(const RobotSource&, const XmlElement&, const char*, std::string_view,
                                  const std::vector<RobotJoint>&);

RobotDescription load_robot(const std::filesystem::path& file, const RobotReading& reading)
{
    std::string bytes = read_file(file, most_bytes), name = file.string();
    if (const std::filesystem::path xacro = is_for_xacro(file, bytes) ? find_program("xacro") : ""; !xacro.empty())
        bytes = expand_xacro(xacro, file), name += ", expanded";
    else if (lower_extension(file) == ".xacro")
        refuse(file.string(), fmt::format("is a file for xacro; expand it first: xacro {} > {}", file.string(),
                                          std::filesystem::path(file).replace_extension().string()));
    if (outermost_element({name, bytes}) == "mujoco") {
        if (!reading.srdf.empty())
            throw Error(ErrorKind::usage, fmt::format("{}: is MJCF, which says itself which pairs are not tested; "
                                                      "leave out the SRDF file",
                                                      file.string()));
        return read_mjcf({{file.string(), bytes}}, file);
    }
    RobotDescription robot = read_urdf({{name, bytes}}, file, reading);
    if (reading.srdf.empty()) {
        for (const RobotJoint& joint : robot.joints) robot.excluded.push_back(std::minmax(joint.parent, joint.child));
        std::ranges::sort(robot.excluded);
    } else {
        const std::string semantic = read_file(reading.srdf, most_bytes);
        read_srdf({{reading.srdf.string(), semantic}}, robot);
    }
    return robot;
}

} // namespace oncollide
