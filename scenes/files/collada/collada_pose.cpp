#include <oncollide/scenes/files/collada/collada_pose.hpp>

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include <oncollide/scenes/files/collada/collada_mesh.hpp>

namespace oncollide {

namespace {

using Eigen::Affine3d;
using Eigen::Vector3d;

/// The element's numbers; throws unless there are exactly N.
template <int N>
Eigen::Matrix<double, N, 1> read(const MeshSource& source, const XmlElement& element)
{
    const std::vector<double> numbers = collada_numbers(source, element);
    if (numbers.size() != std::size_t(N))
        source.fail(fmt::format("<{}> has {} numbers; it must have {}", element.name, numbers.size(), N), element.line);
    return Eigen::Map<const Eigen::Matrix<double, N, 1>>(numbers.data());
}

/// Exact for quarter turns about a coordinate axis.
Affine3d turn(const MeshSource& source, const XmlElement& element)
{
    const Eigen::Vector4d n = read<4>(source, element);
    const double quarters = n[3] / 90, length = n.head<3>().norm();
    if (n[3] == 0) return Affine3d::Identity();
    if (!(length > 1e-9)) source.fail("<rotate> has an axis without direction", element.line);
    const Vector3d axis = n.head<3>() / length;
    if (std::trunc(quarters) != quarters)
        return Affine3d(Eigen::AngleAxisd(std::remainder(n[3], 360.0) / 180 * std::numbers::pi, axis));
    constexpr std::array<double, 4> sines = {0, 1, 0, -1};
    const auto quarter = static_cast<std::size_t>(std::fmod(std::fmod(quarters, 4) + 4, 4));
    const double s = sines[quarter], c = sines[(quarter + 1) % 4];
    Eigen::Matrix3d across;
    across << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
    Affine3d pose = Affine3d::Identity();
    pose.linear() = c * Eigen::Matrix3d::Identity() + s * across + (1 - c) * axis * axis.transpose();
    return pose;
}

/// The pose at the first point that looks at the second point along -z, with the third vector up.
Affine3d look_at(const MeshSource& source, const XmlElement& element)
{
    const Eigen::Matrix<double, 9, 1> n = read<9>(source, element);
    const Vector3d back = n.head<3>() - n.segment<3>(3), right = n.tail<3>().cross(back);
    if (!(back.norm() > 0 && right.norm() > 0)) source.fail("<lookat> looks in no direction", element.line);
    Affine3d pose = Affine3d::Identity();
    pose.linear() << right.normalized(), back.cross(right).normalized(), back.normalized();
    pose.translation() = n.head<3>();
    return pose;
}

} // namespace

Affine3d collada_matrix(const MeshSource& source, const XmlElement& element)
{
    const Eigen::Matrix<double, 16, 1> n = read<16>(source, element);
    Affine3d pose;
    pose.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(n.data());
    if (!((pose.matrix().row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() < 1e-6))
        source.fail(fmt::format("the last row of <{}> must be 0 0 0 1", element.name), element.line);
    pose.makeAffine();
    return pose;
}

Affine3d collada_pose(const MeshSource& source, const XmlElement& node)
{
    Affine3d pose = Affine3d::Identity();
    for (const XmlElement& element : node.children) {
        if (element.name == "matrix") pose = pose * collada_matrix(source, element);
        if (element.name == "translate") pose.translate(read<3>(source, element));
        if (element.name == "rotate") pose = pose * turn(source, element);
        if (element.name == "scale") pose.scale(read<3>(source, element));
        if (element.name == "lookat") pose = pose * look_at(source, element);
        if (element.name == "skew") source.fail("<skew> is not supported; write it as a <matrix>", element.line);
    }
    return pose;
}

Affine3d collada_units(const MeshSource& source, const XmlElement& root)
{
    Affine3d pose = Affine3d::Identity();
    const XmlElement* const asset = root.find("asset");
    const XmlElement* const unit = asset ? asset->find("unit") : nullptr;
    const XmlElement* const axis = asset ? asset->find("up_axis") : nullptr;
    double metres = 1;
    if (unit && !unit->attribute("meter").empty() &&
        !(parse(unit->attribute("meter"), metres) && metres > 0 && metres <= 1e12))
        source.fail(fmt::format("<unit> is of {} metres", oncollide::quoted(unit->attribute("meter"))), unit->line);
    // The format's default is Y_UP.
    std::string up = axis ? axis->text : "Y_UP";
    std::erase_if(up, [](char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; });
    if (up == "Y_UP")
        pose.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    else if (up == "X_UP") // right is -y, out of the screen is z
        pose.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    else if (up != "Z_UP")
        source.fail(fmt::format("<up_axis> is {}; it must be X_UP, Y_UP or Z_UP", oncollide::quoted(up)), axis->line);
    pose.linear() *= metres;
    return pose;
}

} // namespace oncollide
