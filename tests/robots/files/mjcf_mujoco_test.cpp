// The reader of MJCF against MuJoCo's own library.
#ifdef ONCOLLIDE_MUJOCO
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>

#include <mujoco/mujoco.h>

#include "robots/files/random_mjcf.hpp"
#include "temporary_folder.hpp"
#include <oncollide/robots/robot.hpp>

namespace oncollide::mjcf_mujoco_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

class MujocoTruth {
public:
    explicit MujocoTruth(const std::filesystem::path& path)
    {
        char error[1000] = "";
        model_.reset(mj_loadXML(path.c_str(), nullptr, error, sizeof error));
        if (!model_) throw std::runtime_error(error);
        data_.reset(mj_makeData(model_.get()));
    }
    const mjModel& model() const { return *model_; }
    const mjData& data() const { return *data_; }
    /// MuJoCo's joints are in the order of the description's, with quaternions that begin with w.
    void place(const RobotDescription& robot, const std::vector<double>& numbers)
    {
        ASSERT_EQ(numbers.size(), static_cast<std::size_t>(model_->nq));
        std::copy(numbers.begin(), numbers.end(), data_->qpos);
        double* q = data_->qpos;
        for (const RobotJoint& joint : robot.joints) {
            if (joint.kind == JointKind::floating) std::rotate(q + 3, q + 6, q + 7);
            q += joint.kind == JointKind::fixed ? 0 : joint.kind == JointKind::floating ? 7 : 1;
        }
        mj_kinematics(model_.get(), data_.get());
    }
    /// Places the model as the file does.
    void reset()
    {
        mj_resetData(model_.get(), data_.get());
        mj_kinematics(model_.get(), data_.get());
    }
    /// Pairs of geoms that MuJoCo tests, if all of them meet.
    std::set<std::pair<int, int>> contacts()
    {
        mj_comPos(model_.get(), data_.get());
        mj_collision(model_.get(), data_.get());
        std::set<std::pair<int, int>> pairs;
        for (int i = 0; i < data_->ncon; ++i)
            pairs.insert(std::minmax(data_->contact[i].geom1, data_->contact[i].geom2));
        return pairs;
    }
    std::string name(int type, int id) const
    {
        const char* text = mj_id2name(model_.get(), type, id);
        return text ? text : "";
    }

private:
    struct Free {
        void operator()(mjModel* model) const { mj_deleteModel(model); }
        void operator()(mjData* data) const { mj_deleteData(data); }
    };
    std::unique_ptr<mjModel, Free> model_;
    std::unique_ptr<mjData, Free> data_;
};

Isometry3d pose_from(const mjtNum* position, const mjtNum* matrix)
{
    Isometry3d pose;
    pose.translation() = Vector3d(position);
    pose.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix);
    return pose;
}

double difference(const Isometry3d& a, const Isometry3d& b)
{
    return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

/// Whether a shape is a geom of MuJoCo's.
bool is_geom(const Shape& shape, int type, const Vector3d& size)
{
    const auto near = [](double a, double b) { return std::abs(a - b) < 1e-9; };
    if (const auto* s = std::get_if<Sphere>(&shape)) return type == mjGEOM_SPHERE && near(s->radius, size.x());
    if (const auto* s = std::get_if<Capsule>(&shape))
        return type == mjGEOM_CAPSULE && near(s->radius, size.x()) && near(s->length, 2 * size.y());
    if (const auto* s = std::get_if<Cylinder>(&shape))
        return type == mjGEOM_CYLINDER && near(s->radius, size.x()) && near(s->length, 2 * size.y());
    if (const auto* s = std::get_if<Box>(&shape)) return type == mjGEOM_BOX && (s->half - size).norm() < 1e-9;
    if (const auto* s = std::get_if<Ellipsoid>(&shape))
        return type == mjGEOM_ELLIPSOID && (s->semi_axes - size).norm() < 1e-9;
    return std::holds_alternative<HalfSpace>(shape) && type == mjGEOM_PLANE;
}

class MjcfAndMujoco : public ::testing::Test {
protected:
    static std::vector<Isometry3d> link_poses(const RobotDescription& robot, const std::vector<double>& numbers)
    {
        World world;
        const Robot placed(world, robot);
        std::vector<Isometry3d> poses(robot.links.size());
        placed.link_poses(numbers, poses);
        return poses;
    }
    static std::vector<double> numbers_for(const RobotDescription& robot, test::RandomMjcf& random)
    {
        std::vector<double> numbers;
        for (const RobotJoint& joint : robot.joints) {
            if (joint.kind == JointKind::fixed) continue;
            const bool floats = joint.kind == JointKind::floating;
            for (int i = 0; i < (floats ? 3 : 1); ++i) numbers.push_back(random.number(-3, 3));
            if (!floats) continue;
            const Eigen::Vector4d turn =
                Eigen::Vector4d(random.number(-1, 1), random.number(-1, 1), random.number(-1, 1), 0.1).normalized();
            numbers.insert(numbers.end(), turn.begin(), turn.end());
        }
        return numbers;
    }
    /// Compares all bodies and geoms.
    static void compare(const MujocoTruth& truth, const RobotDescription& robot, const std::vector<Isometry3d>& poses)
    {
        const mjModel& m = truth.model();
        for (int b = 0; b < m.nbody; ++b) {
            const std::string name = truth.name(mjOBJ_BODY, b);
            const auto link = std::ranges::find(robot.links, name, &RobotLink::name);
            ASSERT_NE(link, robot.links.end()) << name;
            const Isometry3d truly = pose_from(truth.data().xpos + 3 * b, truth.data().xmat + 9 * b);
            EXPECT_LT(difference(poses[std::size_t(link - robot.links.begin())], truly), 1e-9) << name;
        }
        std::size_t found = 0, all = 0;
        for (const RobotLink& link : robot.links) all += link.collision.size();
        for (int g = 0; g < m.ngeom; ++g) {
            if (m.geom_type[g] == mjGEOM_MESH) continue;
            const std::string body = truth.name(mjOBJ_BODY, m.geom_bodyid[g]);
            const Isometry3d truly = pose_from(truth.data().geom_xpos + 3 * g, truth.data().geom_xmat + 9 * g);
            bool is_there = false;
            for (std::size_t i = 0; i < robot.links.size(); ++i)
                if (robot.links[i].name == body || robot.links[i].name.starts_with(body + "/"))
                    for (const LinkGeometry& own : robot.links[i].collision)
                        is_there |=
                            difference(poses[i] * own.pose, truly) < 1e-9 &&
                            std::holds_alternative<Shape>(own.geometry->data) &&
                            is_geom(std::get<Shape>(own.geometry->data), m.geom_type[g], Vector3d(m.geom_size + 3 * g));
            found += is_there;
            EXPECT_TRUE(is_there || (!m.geom_contype[g] && !m.geom_conaffinity[g]))
                << "geom " << truth.name(mjOBJ_GEOM, g);
        }
        EXPECT_GE(found, all);
    }
    test::TemporaryFolder folder;
};

TEST_F(MjcfAndMujoco, HaveTheSameBodiesAndGeomsInRandomConfigurations)
{
    std::size_t joints = 0, floating = 0, limited = 0;
    for (unsigned seed = 0; seed < 300; ++seed) {
        test::RandomMjcf random(seed, false);
        const std::string text = random.make();
        const auto path = folder.write("model.xml", text);
        SCOPED_TRACE("seed " + std::to_string(seed) + "\n" + text);
        MujocoTruth truth(path);
        const RobotDescription robot = load_robot(path);
        if (std::ranges::all_of(robot.links, &std::vector<LinkGeometry>::empty, &RobotLink::collision)) continue;
        for (int k = 0; k < 5; ++k) {
            const std::vector<double> numbers = numbers_for(robot, random);
            truth.place(robot, numbers);
            compare(truth, robot, link_poses(robot, numbers));
        }
        std::size_t at = 0; // joints of MuJoCo
        for (const RobotJoint& joint : robot.joints) {
            if (joint.kind == JointKind::fixed) continue;
            const bool has_limits = joint.lower > -1e300;
            EXPECT_EQ(has_limits, truth.model().jnt_limited[at]) << joint.name;
            if (has_limits) {
                EXPECT_NEAR(joint.lower, truth.model().jnt_range[2 * at], 1e-12) << joint.name;
                EXPECT_NEAR(joint.upper, truth.model().jnt_range[2 * at + 1], 1e-12) << joint.name;
            }
            ++at, ++joints, floating += joint.kind == JointKind::floating, limited += has_limits;
        }
        // The pose of the file.
        if (at == 0) continue;
        World world;
        const Robot placed(world, robot);
        std::vector<double> start = placed.neutral();
        placed.apply_state("qpos0", "", start);
        truth.reset();
        compare(truth, robot, link_poses(robot, start));
        if (::testing::Test::HasFailure()) return;
    }
    EXPECT_GT(joints, 1000u);
    EXPECT_GT(floating, 50u);
    EXPECT_GT(limited, 200u);
}

TEST_F(MjcfAndMujoco, TestTheSamePairs)
{
    std::size_t tested = 0, filtered = 0;
    for (unsigned seed = 0; seed < 300; ++seed) {
        test::RandomMjcf random(1000 + seed, true);
        const std::string text = random.make();
        const auto path = folder.write("model.xml", text);
        SCOPED_TRACE("seed " + std::to_string(seed) + "\n" + text);
        MujocoTruth truth(path);
        const RobotDescription robot = load_robot(path);
        std::vector<int> link_of(static_cast<std::size_t>(random.geoms()), -1);
        for (std::size_t i = 0; i < robot.links.size(); ++i)
            for (const LinkGeometry& own : robot.links[i].collision) {
                const double radius = std::get<Sphere>(std::get<Shape>(own.geometry->data)).radius;
                link_of.at(std::size_t(2 * (radius - test::RandomMjcf::radius_of(0)) + 0.5)) = static_cast<int>(i);
            }
        truth.place(robot, numbers_for(robot, random));
        const auto contacts = truth.contacts();
        for (int a = 0; a < truth.model().ngeom; ++a)
            for (int b = 0; b < a; ++b) {
                const auto number = [&](int g) { return std::stoi(truth.name(mjOBJ_GEOM, g).substr(1)); };
                const int x = link_of[std::size_t(number(a))], y = link_of[std::size_t(number(b))];
                const bool mine =
                    x >= 0 && y >= 0 && x != y &&
                    !std::ranges::binary_search(
                        robot.excluded, std::pair<std::uint32_t, std::uint32_t>(
                                            std::minmax(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y))));
                const bool theirs = contacts.contains(std::minmax(a, b));
                EXPECT_EQ(mine, theirs) << "geoms g" << number(b) << " and g" << number(a);
                ++(theirs ? tested : filtered);
            }
        if (::testing::Test::HasFailure()) return;
    }
    EXPECT_GT(tested, 1000u);
    EXPECT_GT(filtered, 1000u);
}

TEST_F(MjcfAndMujoco, PlaceMeshesAlike)
{
    folder.write("wedge.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    const auto path = folder.write("model.xml", R"(<mujoco>
<default><default class="small"><mesh scale="0.1 -0.2 0.3"/></default></default>
<asset><mesh file="wedge.obj" class="small" refpos="0.1 0.2 0.3" refquat="1 0.5 0.2 0"/>
  <mesh name="listed" vertex="0 0 0  1 0 0  0 1 0  0 0 1  1 1 1" scale="2 1 1"/>
  <mesh name="faces" vertex="0 0 0  1 0 0  0 1 0  0 0 1" face="0 2 1  0 1 3  0 3 2  1 2 3" refpos="0 0 1"/></asset>
<worldbody><body name="b" pos="1 2 3" euler="10 20 30"><joint/>
  <geom type="mesh" mesh="wedge" pos="0.1 0 0" euler="0 40 0"/>
  <geom type="mesh" mesh="listed" pos="0 0.3 0"/><geom type="mesh" mesh="faces" zaxis="1 0 1"/></body></worldbody>
</mujoco>)");
    MujocoTruth truth(path);
    const RobotDescription robot = load_robot(path);
    ASSERT_EQ(robot.links.size(), 2u);
    truth.place(robot, {0.7});
    const std::vector<Isometry3d> poses = link_poses(robot, {0.7});
    const mjModel& m = truth.model();
    for (int g = 0; g < 3; ++g) {
        const Isometry3d at = pose_from(truth.data().geom_xpos + 3 * g, truth.data().geom_xmat + 9 * g);
        const LinkGeometry& own = robot.links[1].collision.at(std::size_t(g));
        const auto* const mesh = std::get_if<Mesh>(&own.geometry->data);
        const auto& vertices = mesh ? mesh->vertices : std::get<ConvexHull>(std::get<Shape>(own.geometry->data)).points;
        ASSERT_EQ(mesh == nullptr, g == 1);
        const auto count = static_cast<std::size_t>(m.mesh_vertnum[m.geom_dataid[g]]); // more, if they repeat
        const float* v = m.mesh_vert + 3 * m.mesh_vertadr[m.geom_dataid[g]];
        for (const Vector3d& mine : vertices) {
            double nearest = 1;
            for (std::size_t i = 0; i < count; ++i)
                nearest = std::min(
                    nearest, (poses[1] * own.pose * mine - at * Vector3d(v[3 * i], v[3 * i + 1], v[3 * i + 2])).norm());
            EXPECT_LT(nearest, 2e-6) << "geom " << g; // MuJoCo keeps them as floats
        }
    }
}

} // namespace
} // namespace oncollide::mjcf_mujoco_test
#endif
