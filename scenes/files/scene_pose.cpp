#include <oncollide/scenes/files/scene_pose.hpp>

#include <cstring>

#include <oncollide/scenes/files/common/quaternion.hpp>

namespace oncollide {

namespace {

Eigen::Matrix3d matrix_of(FunctionRef<std::string()> place, const Eigen::Vector4d& xyzw,
                          std::vector<std::string>& warnings)
{
    return quaternion_of(place, xyzw, warnings).normalized().toRotationMatrix();
}

} // namespace

Eigen::Isometry3d default_pose(const Motion& motion)
{
    const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
    return std::holds_alternative<Keyed>(motion) ? pose_at(motion, identity, 0) : identity;
}

bool same_bits(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
    return std::memcmp(a.data(), b.data(), sizeof(double) * 3) == 0;
}

bool same_bits(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b)
{
    return std::memcmp(a.data(), b.data(), sizeof(double) * 9) == 0;
}

Eigen::Matrix3d read_rotation(const Node& node, std::vector<std::string>& warnings)
{
    if (node.is_array() && node.size() == 3 && node[0].is_array()) {
        Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows;
        double* out = rows.data();
        for (const Node& row : node) row.numbers(3, out), out += 3;
        return rows;
    }
    if (!node.holds_numbers(4))
        node.fail("must be a quaternion [x, y, z, w] or a matrix of three rows of three numbers");
    Eigen::Vector4d xyzw;
    node.numbers(4, xyzw.data());
    return matrix_of([&] { return node.place(); }, xyzw, warnings);
}

nlohmann::ordered_json rotation_entry(const Eigen::Matrix3d& rotation)
{
    const Eigen::Vector4d xyzw = Eigen::Quaterniond(rotation).normalized().coeffs();
    std::vector<std::string> unused;
    if (same_bits(matrix_of([] { return std::string(); }, xyzw, unused), rotation))
        return {xyzw[0], xyzw[1], xyzw[2], xyzw[3]};
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (int i = 0; i < 3; ++i) rows.push_back({rotation(i, 0), rotation(i, 1), rotation(i, 2)});
    return rows;
}

} // namespace oncollide
