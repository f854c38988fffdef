"""Robot: configurations in arrays, against collide() of the same boxes."""

import numpy as np
import pytest

import oncollide
from conftest import at

ARM = """<robot name="arm">
<link name="base"><collision><geometry><box size="0.3 0.3 0.5"/></geometry></collision></link>
<joint name="turn" type="continuous"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.1"/><axis xyz="0 0 1"/></joint>
<link name="upper"/>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 0.5"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3"/></joint>
<link name="lower"><collision><origin xyz="0 0 0.3"/><geometry><box size="0.05 0.05 0.4"/></geometry></collision></link>
</robot>"""
SRDF = """<robot name="arm"><group name="all"><joint name="elbow"/></group>
<group_state name="bent" group="all"><joint name="elbow" value="1.5"/></group_state></robot>"""


@pytest.fixture
def files(tmp_path):
    (tmp_path / "arm.urdf").write_text(ARM)
    (tmp_path / "arm.srdf").write_text(SRDF)
    return tmp_path


def rotation(axis, angle):
    pose = np.eye(4)
    c, s = np.cos(angle), np.sin(angle)
    i, j = {"z": (0, 1), "y": (2, 0)}[axis]
    pose[i, i] = pose[j, j] = c
    pose[i, j], pose[j, i] = -s, s
    return pose


def test_a_batch_finds_what_pairs_find(files):
    world = oncollide.World()
    wall = world.bodies.add(world.models.add(oncollide.box((0.01, 1, 1))), at(0.4, 0, 1), static=True)
    robot = oncollide.Robot(world, files / "arm.urdf", srdf=files / "arm.srdf")
    assert robot.joints == ["turn", "elbow"] and robot.links == ["base", "upper", "lower"]
    samples = np.random.default_rng(1).uniform((-3, -3), (3, 3), (400, 2))
    found = robot.check(samples)
    colliding = 0
    for (turn, elbow), result in zip(samples, found):
        pose = at(0, 0, 0.1) @ rotation("z", turn) @ at(0, 0, 0.5) @ rotation("y", elbow)
        assert np.allclose(robot.link_poses((turn, elbow))[2], pose, atol=1e-14)
        verdicts = {oncollide.collide(oncollide.box(half), place, oncollide.box((0.025, 0.025, 0.2)), pose @ at(0, 0, 0.3))["verdict"]
                    for half, place in (((0.15, 0.15, 0.25), np.eye(4)), ((0.01, 1, 1), at(0.4, 0, 1)))}
        hit = oncollide.Verdict.COLLIDING in verdicts
        colliding += hit
        assert (result["verdict"] == oncollide.Verdict.COLLIDING) == hit
        if hit:
            assert result["link"] in (0, 2) and (result["other"] >= 0 or result["body"] == wall)
        else:
            assert result["link"] == -1
    assert np.array_equal(robot.link_poses(samples[:3]), [robot.link_poses(q) for q in samples[:3]])
    assert 20 < colliding < 380
    assert np.count_nonzero(robot.check(samples, environment=False)["verdict"]) < colliding
    assert robot.check(samples[0]) == found[0]


def test_copies_are_worlds_of_their_own(files):
    random = np.random.default_rng(2)
    count = 300
    samples = random.uniform((-3, -3), (3, 3), (count, 2))
    poses = np.zeros((count, 2, 7))
    poses[:, :, :3] = random.uniform(-1, 1, (count, 2, 3))
    poses[:, :, 3:] = random.normal(size=(count, 2, 4))
    poses[:, :, 3:] /= np.linalg.norm(poses[:, :, 3:], axis=2, keepdims=True)

    def make(first):
        world = oncollide.World()
        models = [world.models.add(oncollide.box((0.05, 0.4, 0.4))), world.models.add(oncollide.sphere(0.3))]
        bodies = [world.bodies.add(model, pose, static=True) for model, pose in zip(models, first)]
        return bodies, oncollide.Robot(world, files / "arm.urdf")

    bodies, robot = make(poses[0])
    found = robot.check_copies(bodies, poses, samples)
    for k in range(count):
        own_bodies, own = make(poses[k])
        truth = own.check(samples[k])
        assert (found[k]["verdict"], found[k]["link"], found[k]["other"]) == (truth["verdict"], truth["link"], truth["other"])
        assert found[k]["body"] == 0 or bodies.index(found[k]["body"]) == own_bodies.index(truth["body"])
    assert 20 < sum(found["verdict"] == oncollide.Verdict.COLLIDING) < count - 20
    with pytest.raises(ValueError, match=r"expected shape \(300, 2, 4, 4\)"):
        robot.check_copies(bodies, poses[:, :1], samples)
    with pytest.raises(oncollide.Error, match="listed twice"):
        robot.check_copies([bodies[0], bodies[0]], poses, samples)


def test_states_and_errors(files):
    world = oncollide.World()
    robot = oncollide.Robot(world, files / "arm.urdf", srdf=files / "arm.srdf")
    assert robot.state("bent").tolist() == [0, 1.5] and robot.neutral().tolist() == [0, 0]
    with pytest.raises(oncollide.Error, match="no state 'bend'"):
        robot.state("bend")
    with pytest.raises(ValueError, match=r"Robot.check: configurations: expected shape \(N, 2\)"):
        robot.check(np.zeros((3, 3)))
    with pytest.raises(oncollide.Error, match="configuration 1: .*'elbow'"):
        robot.check([[0, 0], [0, np.nan]])
    with pytest.raises(oncollide.Error, match="arm.srdf: line 1"):
        oncollide.Robot(world, files / "arm.srdf")
    with pytest.raises(TypeError, match="packages"):
        oncollide.Robot(world, files / "arm.urdf", packages=["a"])


def test_motions_are_checked_without_gaps(files):
    world = oncollide.World()
    wire = world.bodies.add(world.models.add(oncollide.box((1e-6, 1, 1e-6))), at(0.2, 0, 0.9), static=True)
    robot = oncollide.Robot(world, files / "arm.urdf", srdf=files / "arm.srdf")
    up, down, away = (0, 0), (0, 1.5), (0, -1.5)
    found = robot.check_edges([up, up, down], [down, away, down], tolerance=1e-6)
    assert found["verdict"].tolist() == [oncollide.Verdict.COLLIDING, oncollide.Verdict.SEPARATE, oncollide.Verdict.SEPARATE]
    assert found["body"][0] == wire and found["link"][0] == 2 and found["other"][0] == -1
    assert 0 < found["contact_by"][0] - found["clear_until"][0] <= 1e-6 and np.all(found["clear_until"][1:] == 1)
    before, after = found["clear_until"][0], found["contact_by"][0]
    assert robot.check([(0, 1.5 * before), (0, 1.5 * after)])["verdict"].tolist() == [oncollide.Verdict.SEPARATE, oncollide.Verdict.COLLIDING]
    assert robot.check_edges(up, down, first=False)["verdict"] == oncollide.Verdict.COLLIDING
    with pytest.raises(ValueError, match="Robot.check_edges: end: expected shape"):
        robot.check_edges([up, up], [down])
    with pytest.raises(oncollide.Error, match="end 0: .*'elbow'"):
        robot.check_edges(up, (0, np.nan))
    with pytest.raises(oncollide.Error, match="tolerance"):
        robot.check_edges(up, down, tolerance=0)


def test_distances_have_gradients(files):
    world = oncollide.World()
    wall = world.bodies.add(world.models.add(oncollide.box((0.01, 1, 1))), at(0.6, 0, 1), static=True)
    robot = oncollide.Robot(world, files / "arm.urdf", srdf=files / "arm.srdf")
    samples = np.random.default_rng(2).uniform((-3, -3), (3, 3), (200, 2))
    pairs, gradients, offsets = robot.distances(samples)
    assert offsets.tolist() == list(range(201)) and gradients.shape == (200, 2)
    collides = robot.check(samples)["verdict"] == oncollide.Verdict.COLLIDING
    assert np.array_equal(pairs["upper"] <= 0, collides) and 5 < np.count_nonzero(collides) < 195
    apart = np.flatnonzero(~collides & pairs["unique"])
    gaps = np.linalg.norm(pairs["other_point"] - pairs["point"], axis=1)
    assert np.allclose(gaps[apart], pairs["upper"][apart], atol=1e-9)
    step = 1e-6
    compared = 0
    for i in apart[:40]:
        for k in range(2):
            move = np.zeros(2)
            move[k] = step
            (after,), _ = robot.distances(samples[i] + move)
            (before,), _ = robot.distances(samples[i] - move)
            if (after["link"], after["other"]) == (before["link"], before["other"]):
                compared += abs((after["upper"] - before["upper"]) / (2 * step) - gradients[i, k]) < 1e-5
    assert compared > 50
    near, slopes, offsets = robot.distances(samples, cutoff=0.1, every_pair=True, gradients=False)
    assert slopes.shape == (0, 2) and len(near) == offsets[-1] and np.all(near["upper"] <= 0.1)
    assert set(near["body"][near["other"] < 0]) == {wall}
    one, slope = robot.distances(samples[0])
    assert one[0] == pairs[0] and np.array_equal(slope[0], gradients[0])
    met, flat, _ = robot.distances(samples[collides], depths=False)
    assert np.all(met["upper"] == 0) and not flat.any()
    with pytest.raises(ValueError, match=r"Robot.distances: configurations: expected shape \(N, 2\)"):
        robot.distances(np.zeros((3, 3)))
    with pytest.raises(oncollide.Error, match="tolerance of -1"):
        robot.distances(samples, tolerance=-1)


def test_the_tree_and_its_jacobian(files):
    robot = oncollide.Robot(oncollide.World(), files / "arm.urdf")
    assert robot.parents == [-1, 0, 1]
    assert robot.limits.tolist() == [[-np.inf, np.inf], [-3, 3]]
    q, point, step = np.array([0.3, 0.7]), np.array([0.1, 0.2, 0.3]), 1e-6
    rows = robot.jacobian(q, "lower", point)
    assert np.array_equal(rows, robot.jacobian(q, 2, point))
    place = lambda q: (robot.link_poses(q)[2] @ [*point, 1])[:3]
    for k in range(2):
        move = np.eye(2)[k] * step
        assert np.allclose(rows[:3, k], (place(q + move) - place(q - move)) / (2 * step), atol=1e-8)
    assert np.allclose(rows[3:, 0], [0, 0, 1])
    with pytest.raises(ValueError, match="no link 'hand'"):
        robot.jacobian(q, "hand")
    robot.set_base(at(0, 0, 5))
    assert robot.link_poses(q)[0][2, 3] == 5


def test_attached_objects_and_bodies(files):
    world = oncollide.World()
    world.bodies.add(world.models.add(oncollide.box((0.01, 1, 1))), at(0.9, 0, 1), static=True)
    robot = oncollide.Robot(world, files / "arm.urdf", srdf=files / "arm.srdf")
    q = np.array([0, np.pi / 2])  # the arm points at the wall
    (before,), _ = robot.distances(q, self_collision=False)
    rod = world.models.add(oncollide.box((0.01, 0.01, 0.1)))
    assert robot.attach("lower", rod, at(0, 0, 0.6), touching=["base"]) == 0
    (after,), _ = robot.distances(q, self_collision=False)
    assert np.isclose(before["upper"] - after["upper"], 0.2)
    ids = robot.add_bodies()
    assert np.array_equal(ids, robot.bodies) and len(ids) == 3
    robot.set_joints(q)
    assert np.allclose(world.bodies.pose(int(ids[1])), robot.link_poses(q)[2] @ at(0, 0, 0.3))
    world.step()
    with pytest.raises(oncollide.Error, match="remove_bodies"):
        robot.detach_all()
    robot.remove_bodies()
    robot.detach_all()
    assert len(robot.bodies) == 0
    assert robot.distances(q, self_collision=False)[0]["upper"] == before["upper"]


def test_padding_and_allowed_contacts(files):
    world = oncollide.World()
    wall = world.bodies.add(world.models.add(oncollide.box((0.01, 1, 1))), at(0.4, 0, 1), static=True)
    robot = oncollide.Robot(world, files / "arm.urdf", srdf=files / "arm.srdf")
    samples = np.random.default_rng(2).uniform((-3, -3), (3, 3), (300, 2))
    gaps, _, _ = robot.distances(samples, self_collision=False, gradients=False)
    plain = robot.check(samples, self_collision=False)
    refused = lambda: robot.check(samples, self_collision=False)["verdict"] != oncollide.Verdict.SEPARATE
    robot.set_padding(environment=0.05)
    assert np.array_equal(refused(), gaps["upper"] <= 0.05) and np.count_nonzero(refused()) > np.count_nonzero(plain["verdict"])
    robot.set_padding(links={"lower": 0.1, 0: 0.3})
    within = {0: 0.3, 2: 0.1}
    pairs, _, offsets = robot.distances(samples, every_pair=True, self_collision=False, gradients=False)
    expected = [any(p["upper"] <= within[p["link"]] for p in pairs[offsets[i]:offsets[i + 1]]) for i in range(300)]
    assert np.array_equal(refused(), expected)
    robot.set_padding(bodies={wall: 0.05, ("base", wall): 0.7}, pairs={("base", 2): 0.01})
    assert refused().all()
    robot.set_allowed(bodies=[("base", wall), (2, wall)])
    assert not refused().any()
    robot.set_padding()
    robot.set_allowed(links=[("base", "lower")])
    assert np.array_equal(robot.check(samples)["verdict"], plain["verdict"])
    with pytest.raises(TypeError, match="pairs"):
        robot.set_padding(pairs={"base": 1})
    with pytest.raises(oncollide.Error, match="clearance of -1"):
        robot.set_padding(environment=-1)
    with pytest.raises(ValueError, match="no link 'hand'"):
        robot.set_allowed(links=[("hand", "base")])


def test_the_clearance_of_a_motion(files):
    world = oncollide.World()
    wall = world.bodies.add(world.models.add(oncollide.box((0.01, 1, 1))), at(0.4, 0, 1), static=True)
    robot = oncollide.Robot(world, files / "arm.urdf", srdf=files / "arm.srdf")
    start, end = np.array([[-2.0, 1.0], [0, -0.5], [0, 0]]), np.array([[2.0, 1.0], [0, 0.5], [0, 1.5]])
    found = robot.edge_clearance(start, end, tolerance=1e-4, self_collision=False)
    for i in range(3):
        steps = np.linspace(start[i], end[i], 2001)
        pairs, _, _ = robot.distances(steps, self_collision=False, gradients=False, depths=False)
        assert found[i]["lower"] <= pairs["upper"].min() and found[i]["upper"] - found[i]["lower"] <= 1e-4
        assert abs(found[i]["upper"] - pairs["upper"].min()) < 1e-3
    assert found[1]["upper"] > 0.05 and found[2]["upper"] == 0 and found[2]["body"] == wall
    assert robot.edge_clearance(start[1], end[1], tolerance=1e-4, self_collision=False) == found[1]
