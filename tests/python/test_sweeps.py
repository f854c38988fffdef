"""Moving models and bodies: pairs.sweep, space.cast_model and bodies.set_motion."""

import numpy as np
import pytest

import oncollide
from conftest import at
from oncollide import Verdict


def test_two_spheres_meet_where_their_centres_are_the_radii_apart():
    world = oncollide.World()
    ball, small = world.models.add(oncollide.sphere(1.0)), world.models.add(oncollide.sphere(0.5))
    ends = np.stack([at(4, y, 0) for y in (0.9, 1.4, 1.6)])
    starts = np.stack([at(-4, y, 0) for y in (0.9, 1.4, 1.6)])
    found = world.pairs.sweep((ball, None), (small, starts, ends))
    assert found["verdict"].tolist() == [Verdict.COLLIDING, Verdict.COLLIDING, Verdict.SEPARATE]
    for sweep, y in zip(found[:2], (0.9, 1.4)):
        time = (4 - np.sqrt(1.5**2 - y**2)) / 8
        assert sweep["clear_until"] <= time <= sweep["contact_by"] <= sweep["clear_until"] + 1e-4
    assert (found[2]["clear_until"], found[2]["contact_by"]) == (1, np.inf)


def test_a_cast_of_a_model_gives_the_first_body_and_the_last_valid_time():
    world = oncollide.World()
    box, ball = world.models.add(oncollide.box([1, 1, 1])), world.models.add(oncollide.sphere(0.5))
    far, near = world.bodies.add(box, at(8, 0, 0)), world.bodies.add(box, at(4, 0, 0))
    ends = np.stack([at(20, 0, 0), at(0, 20, 0)])
    hits = world.space.cast_model(ball, None, ends)
    assert hits["body"].tolist() == [near, 0]
    assert hits[0]["clear_until"] <= 2.5 / 20 <= hits[0]["contact_by"]
    assert world.space.cast_model(ball, None, ends[0]) == hits[0]
    assert world.space.cast_all_model(ball, None, ends[0])["body"].tolist() == [near, far]
    assert world.space.cast_all_model(ball, None, ends)[1].tolist() == [0, 2, 2]


def test_a_sweep_passes_a_hidden_gap_or_stops_at_a_touch():
    world = oncollide.World()
    floor, box = world.models.add(oncollide.box([10, 10, 0.5])), world.models.add(oncollide.box([0.5, 0.5, 0.5]))
    ways = (box, at(-5, 0, 0.5 + 1e-13), at(5, 0, 0.5 + 1e-13)), (floor, at(0, 0, -0.5))
    passes, stops = world.pairs.sweep(*ways), world.pairs.sweep(*ways, stop="touch")
    assert (passes["verdict"], stops["verdict"]) == (Verdict.WITHIN, Verdict.WITHIN)
    assert passes["grazes_until"] == 1 and stops["grazes_until"] < 1
    assert world.pairs.sweep(*ways, stop="press")["verdict"] == Verdict.WITHIN
    with pytest.raises(ValueError, match='expected "contact", "touch" or "press"'):
        world.pairs.sweep(*ways, stop="hit")
    body = world.bodies.add(floor, at(0, 0, -0.5))
    assert world.pairs.sweep(ways[0], body) == passes, "a side may be a body"


def test_frames_report_contacts_on_the_way():
    world = oncollide.World()
    world.bodies.add(world.models.add(oncollide.box([0.01, 5, 5])), static=True)
    bullet = world.bodies.add(world.models.add(oncollide.sphere(0.005)), at(-3, 0, 0))
    world.step()
    world.bodies.set_motion([bullet], at(997, 0, 0))
    frame = world.step()
    assert frame.pairs["verdict"].tolist() == [Verdict.COLLIDING]
    assert frame.sweeps["pair"].tolist() == [0]
    assert frame.sweeps["contact_by"][0] == pytest.approx((3 - 0.015) / 1000, abs=1e-6)
    assert len(world.step().sweeps) == 0


@pytest.mark.parametrize("times", [None, [0, 0.25, 1]])
def test_a_body_moves_through_poses_and_back_within_one_frame(times):
    world = oncollide.World()
    world.bodies.add(world.models.add(oncollide.box([0.01, 5, 5])), static=True)
    bullet = world.bodies.add(world.models.add(oncollide.sphere(0.01)), at(-3, 0, 0))
    world.step()
    world.bodies.set_motion(bullet, np.stack([at(-3, 0, 0), at(5, 0, 0), at(-3, 0, 0)]), times)
    sweeps = world.step().sweeps
    assert len(sweeps) == 1
    time = (3 - 0.02) / 8 * (0.5 if times is None else 0.25)
    assert sweeps["clear_until"][0] <= time <= sweeps["contact_by"][0] <= time + 1e-4
    assert world.bodies.pose(bullet)[0, 3] == -3
    world.bodies.set_motion(bullet, np.stack([at(-3, 0, 0), at(-0.1, 0, 0), at(-3, 0, 0)]), times)
    assert Verdict.COLLIDING not in world.step().pairs["verdict"].tolist()


def test_wrong_keys_are_named():
    world = oncollide.World()
    ball = world.bodies.add(world.models.add(oncollide.sphere(1.0)))
    poses = np.tile(np.eye(4), (3, 1, 1))
    with pytest.raises(ValueError, match="bodies.set_motion: pose: expected one pose, or at least two, got 1"):
        world.bodies.set_motion(ball, np.eye(4)[None])
    with pytest.raises(ValueError, match="bodies.set_motion: times: one body that moves through many poses has times"):
        world.bodies.set_motion([ball], np.eye(4), [0, 1])
    with pytest.raises(ValueError, match="bodies.set_motion: times: expected one per pose, 3, got"):
        world.bodies.set_motion(ball, poses, [0, 1])
    with pytest.raises(oncollide.Error, match="motion: key 2: time 0.5 does not come after the time before it, 0.5"):
        world.bodies.set_motion(ball, poses, [0, 0.5, 0.5])
    with pytest.raises(oncollide.Error, match="motion: its keys run from time 0 to 2; they must run from 0 to 1"):
        world.bodies.set_motion(ball, poses, [0, 1, 2])
    with pytest.raises(oncollide.Error, match="motion: key 1: the pose is not finite"):
        world.bodies.set_motion(ball, poses * [[[1]], [[np.nan]], [[1]]])


def test_wrong_arguments_are_named():
    world = oncollide.World()
    ball = world.models.add(oncollide.sphere(1.0))
    with pytest.raises(ValueError, match='pairs.sweep: path: expected "linear" or "screw", got "arc"'):
        world.pairs.sweep((ball, None), (ball, None), path="arc")
    with pytest.raises(ValueError, match="space.cast_model: end: 2 entries, but an earlier argument has 3"):
        world.space.cast_model(ball, np.tile(np.eye(4), (3, 1, 1)), np.tile(np.eye(4), (2, 1, 1)))
    with pytest.raises(oncollide.Error, match="time_tolerance 0: must be at least 1e-12"):
        world.pairs.sweep((ball, None), (ball, None), time_tolerance=0)
    with pytest.raises(oncollide.Error, match="motion: last pose: the pose is not finite"):
        world.space.cast_model(ball, np.eye(4), np.full((4, 4), np.nan))
