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
