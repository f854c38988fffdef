"""Threads, forks, Ctrl-C, the end of the interpreter, and objects that Python has released."""

import gc
import os
import signal
import threading
import time
import weakref

import numpy as np
import pytest

import oncollide
from conftest import at

SLOW = """
import numpy as np, oncollide
def slow(**settings):  # one step takes many seconds
    world = oncollide.World(**settings)
    model = world.models.add(oncollide.torus_knot_mesh(2, 3, 1, 0.4, 0.15, 20000))
    poses = np.tile(np.eye(4), (900, 1, 1))
    poses[:, :3, 3] = np.random.default_rng(1).normal(size=(900, 3)) * 0.5
    world.bodies.add(model, poses)
    return world
"""


def slow(**settings):
    names = {}
    exec(SLOW, names)
    return names["slow"](**settings)


def test_a_world_keeps_what_python_lets_go_of():
    world = oncollide.World(exact="predicates")

    def add():
        vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
        mesh = oncollide.mesh(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
        gone = weakref.ref(vertices)
        model = world.models.add(mesh)
        return world.bodies.add(model), world.bodies.add(model, at(0.2, 0.1, 0.1)), gone

    a, b, gone = add()
    gc.collect()
    assert gone() is None
    for _ in range(3):
        junk = [np.ones(1000) for _ in range(100)]
        assert world.step().pairs["verdict"].tolist() == [oncollide.Verdict.COLLIDING], junk[0]
    contacts, bodies = world.pairs.contacts(a, b), world.bodies
    frame = world.step()
    pairs, began = frame.pairs, frame.began
    del world, frame
    gc.collect()
    assert len(contacts) > 0 and pairs["a"][0] == a and len(began) == 0
    assert len(bodies) == 2, "a part of a World keeps it alive"


def test_other_threads_run_while_a_world_steps_and_are_refused_by_it():
    world = slow(depth=6)
    fault, counted, first = [], 0, world.bodies.at(0)
    stepping = threading.Thread(target=lambda: fault.append(step(world)), daemon=True)

    def step(of):
        try:
            of.step()
        except BaseException as error:  # noqa: BLE001
            return error

    stepping.start()
    refused = None
    for _ in range(200):
        time.sleep(0.002)
        counted += 1
        try:
            world.bodies.pose(first)
        except oncollide.Error as error:
            refused = error
    assert stepping.is_alive() and counted == 200
    assert "bodies.pose: another thread is in a call of this object" in str(refused) and refused.kind == "usage"
    with pytest.raises(oncollide.Error, match="bodies.set_pose: another thread"):
        world.bodies.set_pose(first, at(0))
    # The thread continues during the following tests; it is a daemon.


def test_const_calls_run_side_by_side():
    world = oncollide.World(max_error=0.001)
    knot = world.models.add(oncollide.torus_knot_mesh(2, 3, 1, 0.4, 0.15, 2000))
    poses = np.tile(np.eye(4), (40, 1, 1))
    poses[:, :3, 3] = np.random.default_rng(1).normal(size=(40, 3))
    world.bodies.add(knot, poses)
    expected = world.space.overlaps(knot, poses)[0]["body"].tolist()
    faults = []

    def work():
        try:
            for _ in range(10):
                assert world.space.overlaps(knot, poses)[0]["body"].tolist() == expected
                world.pairs.distance(world.bodies.at(0), world.bodies.at(1))
        except BaseException as error:  # noqa: BLE001
            faults.append(error)

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not faults


def test_threads_may_all_be_the_first_to_call(run_python):
    """A one-time initialisation in a call must not wait for the interpreter's lock while another thread waits for it."""
    code = """
import sys, threading, numpy as np, oncollide
world = oncollide.World(exact="predicates")
ball = world.models.add(oncollide.sphere_mesh(1.0, 200))
a, b = world.bodies.add(ball), world.bodies.add(ball, np.array([1.5, 0, 0, 0, 0, 0, 1]))
frame = world.step()
sys.setswitchinterval(1e-6)
calls = [lambda: world.pairs.distance(a, b), lambda: world.pairs.contacts(a, b), lambda: world.space.overlaps(ball, np.eye(4)),
         lambda: world.space.overlaps(ball, np.eye(4)[None]), lambda: frame.pairs, lambda: frame.began]
for call in calls:
    ready = threading.Barrier(6)
    threads = [threading.Thread(target=lambda: (ready.wait(), call())) for _ in range(6)]
    for thread in threads: thread.start()
    for thread in threads: thread.join()
print(len(frame.pairs))
"""
    for _ in range(5):
        assert run_python(code) == (0, "1\n", "")


def test_a_world_with_a_gpu_belongs_to_its_thread():
    try:
        world = oncollide.World(backend="gl-compute", depth=4)
    except oncollide.Error as error:
        assert error.kind == "no_gpu"
        pytest.skip(str(error))
    world.bodies.add(world.models.add(oncollide.sphere_mesh(1.0, 200)), [at(0), at(1)])
    assert len(world.step().began) == 1
    refused = []

    def step():
        try:
            world.step()
        except oncollide.Error as error:
            refused.append(str(error))

    thread = threading.Thread(target=step)
    thread.start(), thread.join()
    assert "belongs to the thread that made it" in refused[0]


@pytest.mark.parametrize("settings", [{"depth": 6}, {"max_error": 1e-4}, {"exact": "predicates", "threads": 2}], ids=str)
def test_ctrl_c_ends_a_step_soon_and_the_world_goes_on(settings):
    world = slow(**settings)
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        world.step()
    assert time.monotonic() - begin < 5
    world.bodies.remove([world.bodies.at(i) for i in range(4, 900)])
    assert len(world.step().pairs) == 6


def test_ctrl_c_ends_a_batch_of_queries():
    world = oncollide.World(max_error=1e-5)
    knot = world.models.add(oncollide.torus_knot_mesh(2, 3, 1, 0.4, 0.15, 20000))
    poses = np.tile(np.eye(4), (300_000, 1, 1))
    poses[:, :3, 3] = np.random.default_rng(1).normal(size=(300_000, 3))
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        world.pairs.decide((knot, None), (knot, poses))
    assert time.monotonic() - begin < 5
    assert world.pairs.decide((knot, None), (knot, at(9)))["verdict"] == oncollide.Verdict.SEPARATE


def test_ctrl_c_in_one_thread_leaves_the_results_of_others_whole():
    world = oncollide.World(max_error=1e-4)
    knot = world.models.add(oncollide.torus_knot_mesh(2, 3, 1, 0.4, 0.15, 2000))
    poses = np.tile(np.eye(4), (100_000, 1, 1))
    poses[:, :3, 3] = np.random.default_rng(1).normal(size=(100_000, 3))
    expected, found, ends = world.pairs.decide((knot, None), (knot, poses[:500])).tobytes(), [], threading.Event()

    def work():
        while not ends.is_set():
            found.append(world.pairs.decide((knot, None), (knot, poses[:500])).tobytes())

    thread = threading.Thread(target=work)
    thread.start()
    for _ in range(5):
        with pytest.raises(KeyboardInterrupt):
            threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT)).start()
            while True:
                world.pairs.decide((knot, None), (knot, poses))
    ends.set()
    thread.join()
    assert len(found) > 3 and set(found) == {expected}


def test_a_handler_of_a_signal_cannot_use_the_world_that_it_interrupts():
    world = slow(depth=6)
    body, model, refused = world.bodies.at(0), world.models.at(0), []

    def handle(*_):
        try:
            world.bodies.pose(body)
        except oncollide.Error as error:
            signal.setitimer(signal.ITIMER_REAL, 0)
            refused.append(str(error))
            raise KeyboardInterrupt from None

    before = signal.signal(signal.SIGALRM, handle)
    try:
        for call in (world.step, lambda: world.pairs.decide((model, None), (model, np.tile(at(0.1), (300_000, 1, 1))))):
            signal.setitimer(signal.ITIMER_REAL, 0.2, 0.2)  # also again, if the call has not begun
            with pytest.raises(KeyboardInterrupt):
                call()
    finally:
        signal.signal(signal.SIGALRM, before)
    assert len(refused) == 2 and all("bodies.pose: a signal handler cannot use the World" in text for text in refused)
    assert world.bodies.pose(body).shape == (4, 4)


def test_a_handler_of_a_signal_may_go_on():
    world = slow(depth=6)
    seen = []
    before = signal.signal(signal.SIGALRM, lambda *_: seen.append(time.monotonic()))
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
        with pytest.raises(KeyboardInterrupt):
            world.step()
    finally:
        signal.signal(signal.SIGALRM, before)
    assert len(seen) == 1, "handled within the step, which continued"


@pytest.mark.parametrize("threads", [1, 2])
def test_the_interpreter_may_end_in_the_middle_of_a_step(run_python, threads):
    code = SLOW + f"""
import threading, time
world = slow(depth=6, threads={threads})
def forever():
    small = oncollide.World(threads={threads})
    small.bodies.add(small.models.add(oncollide.sphere(1.0)), np.tile(np.eye(4), (50, 1, 1)))
    while True: small.step()
for work in (world.step, forever, forever): threading.Thread(target=work, daemon=True).start()
time.sleep(0.3)
print("ends", flush=True)
"""
    for _ in range(3):
        code_, out, err = run_python(code)
        assert (code_, out.strip(), err) == (0, "ends", "")


def test_a_world_may_be_let_go_of_as_the_interpreter_ends(run_python):
    code = """
import oncollide
class Late:
    def __init__(self):
        self.world = oncollide.World()
        self.world.bodies.add(self.world.models.add(oncollide.sphere(1.0)))
    def __del__(self): print(len(self.world.bodies), self.world.step().frame, flush=True)
late = Late()
kept = Late(); kept.self = kept
"""
    code_, out, err = run_python(code)
    assert code_ == 0 and err == "" and out.startswith("1 0\n")


def test_a_child_of_fork_computes_on_its_own(run_python):
    code = """
import os, numpy as np, oncollide
world = oncollide.World(threads=3, max_error=0.01)
poses = np.tile(np.eye(4), (200, 1, 1)); poses[:, 0, 3] = np.arange(200) * 0.7
world.bodies.add(world.models.add(oncollide.torus_knot_mesh(2, 3, 1, 0.4, 0.15, 600)), poses)
ball = world.models.add(oncollide.sphere(1.0))
first = world.step().hash, world.pairs.decide((ball, None), (ball, poses))["verdict"].sum()
child = os.fork()
again = world.step().hash, world.pairs.decide((ball, None), (ball, poses))["verdict"].sum()
assert again == first, (again, first)
if child: assert os.waitpid(child, 0)[1] == 0
"""
    assert run_python(code) == (0, "", "")


def test_a_world_that_was_forked_in_the_middle_of_a_step_says_so(run_python):
    code = SLOW + """
import os, threading, time
world = slow(depth=6, threads=2)
threading.Thread(target=world.step, daemon=True).start()
time.sleep(0.3)
child = os.fork()
if child == 0:
    try: world.step(); print("no error", flush=True)
    except oncollide.Error as error: print(error, flush=True)
    fresh = oncollide.World(threads=2)
    fresh.bodies.add(fresh.models.add(oncollide.sphere(1.0)), np.tile(np.eye(4), (50, 1, 1)))
    print(len(fresh.step().pairs), flush=True)
else:
    assert os.waitpid(child, 0)[1] == 0
"""
    code_, out, err = run_python(code)
    assert code_ == 0 and err == ""
    lines = out.splitlines()
    assert "or was when this process was forked" in lines[0] and lines[1] == "1225"


def test_worlds_come_and_go_without_leaks():
    import resource

    def cycle():
        world = oncollide.World(exact="predicates")
        model = world.models.add(oncollide.sphere_mesh(1.0, 500))
        world.bodies.add(model, [at(0.3 * i) for i in range(5)])
        frame = world.step()
        assert len(frame.pairs) == 10 and len(world.pairs.contacts(world.bodies.at(0), world.bodies.at(1))) > 0
        world.pairs.decide((model, None), (model, np.stack([at(0), at(1)])))
        with pytest.raises(oncollide.Error):
            world.bodies.pose(99)

    for _ in range(20):
        cycle()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(60):
        cycle()
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 20_000, "KiB"
