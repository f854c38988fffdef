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
    model = world.add(oncollide.torus_knot_mesh(2, 3, 1, 0.4, 0.15, 20000))
    poses = np.tile(np.eye(4), (900, 1, 1))
    poses[:, :3, 3] = np.random.default_rng(1).normal(size=(900, 3)) * 0.5
    world.add_bodies(model, poses)
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
        model = world.add(mesh)
        return world.add_body(model), world.add_body(model, at(0.2, 0.1, 0.1)), gone

    a, b, gone = add()
    gc.collect()
    assert gone() is None
    for _ in range(3):
        junk = [np.ones(1000) for _ in range(100)]
        assert world.step().pairs["verdict"].tolist() == [oncollide.Verdict.COLLIDING], junk[0]
    contacts = world.contacts(a, b)
    frame = world.step()
    pairs, began = frame.pairs, frame.began
    del world, frame
    gc.collect()
    assert len(contacts) > 0 and pairs["a"][0] == a and len(began) == 0


def test_other_threads_run_while_a_world_steps_and_are_refused_by_it():
    world = slow(depth=6)
    fault, counted, first = [], 0, world.body_at(0)
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
            world.pose(first)
        except oncollide.Error as error:
            refused = error
    assert stepping.is_alive() and counted == 200
    assert "World.pose: another thread is in a call of this object" in str(refused) and refused.kind == "usage"
    with pytest.raises(oncollide.Error, match="World.set_pose: another thread"):
        world.set_pose(first, at(0))
    # The thread continues during the following tests; it is a daemon.


def test_const_calls_run_side_by_side():
    world = oncollide.World(max_error=0.001)
    knot = world.add(oncollide.torus_knot_mesh(2, 3, 1, 0.4, 0.15, 2000))
    poses = np.tile(np.eye(4), (40, 1, 1))
    poses[:, :3, 3] = np.random.default_rng(1).normal(size=(40, 3))
    world.add_bodies(knot, poses)
    expected = world.query_batch(knot, poses)[0]["body"].tolist()
    faults = []

    def work():
        try:
            for _ in range(10):
                assert world.query_batch(knot, poses)[0]["body"].tolist() == expected
                world.distance(world.body_at(0), world.body_at(1))
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
ball = world.add(oncollide.sphere_mesh(1.0, 200))
a, b = world.add_body(ball), world.add_body(ball, np.array([1.5, 0, 0, 0, 0, 0, 1]))
frame = world.step()
sys.setswitchinterval(1e-6)
calls = [lambda: world.distance(a, b), lambda: world.contacts(a, b), lambda: world.query(ball, np.eye(4)),
         lambda: world.query_batch(ball, np.eye(4)[None]), lambda: frame.pairs, lambda: frame.began]
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
    world.add_bodies(world.add(oncollide.sphere_mesh(1.0, 200)), [at(0), at(1)])
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
    world.remove_bodies([world.body_at(i) for i in range(4, 900)])
    assert len(world.step().pairs) == 6


def test_ctrl_c_ends_a_batch_of_queries():
    queries = oncollide.Queries([oncollide.torus_knot_mesh(2, 3, 1, 0.4, 0.15, 20000)], max_error=1e-5)
    poses = np.tile(np.eye(4), (300_000, 1, 1))
    poses[:, :3, 3] = np.random.default_rng(1).normal(size=(300_000, 3))
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        queries.run(0, 0, np.eye(4), poses)
    assert time.monotonic() - begin < 5
    assert queries.run(0, 0, np.eye(4), at(9))[0].tolist() == [oncollide.Verdict.SEPARATE]


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
    small.add_bodies(small.add(oncollide.sphere(1.0)), np.tile(np.eye(4), (50, 1, 1)))
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
        self.world.add_body(self.world.add(oncollide.sphere(1.0)))
    def __del__(self): print(len(self.world), self.world.step().frame, flush=True)
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
world.add_bodies(world.add(oncollide.torus_knot_mesh(2, 3, 1, 0.4, 0.15, 600)), poses)
queries = oncollide.Queries([oncollide.sphere(1.0)], threads=3)
first = world.step().hash, queries.run(0, 0, np.eye(4), poses)[0].sum()
child = os.fork()
again = world.step().hash, queries.run(0, 0, np.eye(4), poses)[0].sum()
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
    fresh.add_bodies(fresh.add(oncollide.sphere(1.0)), np.tile(np.eye(4), (50, 1, 1)))
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
        model = world.add(oncollide.sphere_mesh(1.0, 500))
        world.add_bodies(model, [at(0.3 * i) for i in range(5)])
        frame = world.step()
        assert len(frame.pairs) == 10 and len(world.contacts(world.body_at(0), world.body_at(1))) > 0
        oncollide.Queries([oncollide.sphere(1.0)]).run(0, 0, np.eye(4), np.eye(4))
        with pytest.raises(oncollide.Error):
            world.pose(99)

    for _ in range(20):
        cycle()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(60):
        cycle()
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 20_000, "KiB"
