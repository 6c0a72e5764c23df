"""Functions as laws."""

import gc
import os
import signal
import threading
import time
import weakref

import numpy as np
import pytest
import vesper


@vesper.law(adds="force")
def drag(velocity):
    return -0.1 * velocity


def thrown(laws, **more):
    bodies = {"position": [[0, 0, 0], [1, 1, 1]], "velocity": [[1, 0, 0], [0, 2, 0]], "mass": [1, 2]}
    settings = {"laws": ["motion", *laws], "step": 1e-3, "constants": {"gravity": [0, 0, -9.81]}} | more
    return vesper.Engine(domains={"bodies": bodies}, **settings)


def test_a_function_is_a_law():
    engine = thrown([drag], integrator="runge_kutta_4")
    engine.advance(1.0)
    velocity = engine.get("bodies", "velocity")
    assert velocity[0, 0] == pytest.approx(np.exp(-0.1), rel=1e-12)
    assert velocity[1, 1] == pytest.approx(2 * np.exp(-0.05), rel=1e-12)
    assert "drag" in engine.report()


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_it_gives_the_bits_of_the_stock_law(precision):
    @vesper.law(adds="force", constants="gravity")
    def weight(mass, gravity):
        assert mass.shape == (2,) and gravity.shape == (3,)
        return mass[:, None] * gravity

    ours, theirs = thrown([weight], precision=precision), thrown(["uniform_gravity"], precision=precision)
    for engine in (ours, theirs):
        engine.step(1000, 1e-3)
    assert np.array_equal(ours.get("bodies", "position"), theirs.get("bodies", "position"))


def test_shares_of_several_laws_are_summed():
    engine = thrown([drag, "uniform_gravity"])
    engine.observe("bodies", "force")
    assert engine.get("bodies", "force").tolist() == [[-0.1, 0, -9.81], [0, -0.2, -19.62]]
    force = engine["bodies", "force"]
    engine.step(10, 1e-3)
    assert force.x[0] == pytest.approx(-0.1 * engine["bodies", "velocity"].x[0], rel=1e-3)


def test_rates_sets_and_properties_of_ones_own():
    @vesper.law(rates="heat", sets="glow", widths={"spin": 3})
    def cool(heat, spin):
        assert heat.shape == (3,) and spin.shape == (3, 3)
        return {"heat": -heat, "glow": 2 * heat}

    grains = {"heat": [1.0, 2, 3], "spin": np.ones((3, 3))}
    engine = vesper.Engine(domains={"grains": grains}, laws=[cool], integrator="runge_kutta_4", step=1e-2)
    engine.observe("grains", "glow")
    engine.advance(1.0)
    assert engine.get("grains", "heat") == pytest.approx(np.exp(-1) * np.array([1, 2, 3]))
    assert np.array_equal(engine.get("grains", "glow"), 2 * engine.get("grains", "heat"))


def breaks(after, error=KeyError("no more"), **more):
    """A law that raises in each call after so many, and the list of its calls."""
    calls = []

    def broken(velocity):
        calls.append(velocity)
        if len(calls) > after:
            raise error
        return 0.0

    return vesper.Law(broken, **({"adds": "force", "name": "broken"} | more)), calls


def test_an_exception_comes_through_and_undoes_a_few_steps():
    broken, calls = breaks(40)
    engine = thrown([broken, "uniform_gravity"])
    twin = thrown([breaks(1e9)[0], "uniform_gravity"])
    with pytest.raises(KeyError, match="no more"):
        engine.step(100, 1e-3)
    assert len(calls) == 41
    # Two evaluations make a step here. The engine stands where it was a few steps before, at a whole sixteen of them.
    assert engine.steps == 16
    twin.step(engine.steps, 1e-3)
    assert np.array_equal(engine.get("bodies", "position"), twin.get("bodies", "position"))
    assert engine.time == twin.time
    # The next call is a call as any other.
    calls.clear()
    for each in (engine, twin):
        each.step(18, 1e-3)
    assert np.array_equal(engine.get("bodies", "position"), twin.get("bodies", "position"))


@pytest.mark.parametrize("lend", [False, True])
@pytest.mark.parametrize("call", ["step", "frame"])
def test_an_exception_in_a_single_step_leaves_the_engine_as_it_was(call, lend):
    broken, calls = breaks(0)
    place = np.array([[0.0, 0, 0], [1, 1, 1]])
    bodies = {"position": place, "velocity": np.ones((2, 3)), "mass": np.ones(2)}
    engine = vesper.Engine(domains={"bodies": bodies}, laws=["motion", broken], step=1e-3, lend=lend)
    with pytest.raises(KeyError, match="no more"):
        engine.step(1, 1e-3) if call == "step" else engine.advance(1e-3)
    assert engine.steps == 0 and engine.time == 0
    assert np.array_equal(engine.get("bodies", "position"), place) and place[1, 0] == 1


def test_frames_have_as_many_steps_whatever_is_carried_on():
    ours, theirs = thrown([drag]), thrown([drag])
    for frame in (0.0105, 0.0995, 0.25, 1e-4, 0.0329):
        ours.advance(frame)
    for _ in range(393):
        theirs.step(1, 1e-3)
    assert ours.steps == 393
    assert np.array_equal(ours.get("bodies", "position"), theirs.get("bodies", "position"))
    one = vesper.Engine(domains={"bodies": {"position": [[0, 0, 0]], "velocity": [[1, 0, 0]], "mass": 1}}, laws=["motion"])
    one.advance(1000.0)
    assert one.steps == 1


def test_of_two_laws_that_raise_the_first_is_told_and_none_is_left():
    first, calls = breaks(5, KeyError("first"), name="first")
    second, others = breaks(5, KeyError("second"), name="second")
    engine = thrown([first, second])
    with pytest.raises(KeyError, match="first|second"):
        engine.step(10, 1e-3)
    assert len(calls) + len(others) == 11 and engine.steps == 0
    calls.clear()
    others.clear()
    # Nothing is left of either: the same laws work again.
    engine.step(2, 1e-3)
    assert engine.steps == 2


def test_a_law_that_only_sets_what_is_observed_ends_the_call_too():
    broken, calls = breaks(3, adds=(), sets="glow")
    engine = thrown([broken], observe=["bodies.glow"])
    with pytest.raises(KeyError, match="no more"):
        engine.step(1000, 1e-3)
    # Nothing that moves follows from it: the steps were taken, and stay; the results are NaN.
    assert 0 < engine.steps < 1000 and np.isnan(engine.get("bodies", "glow")).all()
    calls.clear()
    engine.step(1, 1e-3)


@pytest.mark.parametrize("ask", ["report", "explain", "dot"])
def test_an_exception_comes_out_of_any_call_that_evaluates_laws(ask):
    calls = []

    @vesper.law(sets="glow")
    def broken(velocity):
        calls.append(velocity)
        if len(calls) in (2, 4):
            raise KeyError("no more")
        return 1 + 0 * velocity[:, 0]

    engine = thrown([broken])
    engine.observe("bodies", "glow")
    with pytest.raises(KeyError, match="no more"):
        getattr(engine, ask)()
    # It is told once.
    assert getattr(engine, ask)() and engine.get("bodies", "glow").tolist() == [1, 1]
    other = thrown([broken])
    with pytest.raises(KeyError, match="no more"):
        other.observe("bodies", "glow")


def test_laws_on_threads_of_the_engine_do_not_wait_for_each_other():
    # A call that kept Python's lock would wait for ever for a law on another thread.
    laws = [vesper.Law(lambda velocity: 0 * velocity, adds="force", name=f"law_{k}") for k in range(4)]
    glow = vesper.Law(lambda velocity: 1 + 0 * velocity[:, 0], sets="glow", name="glow")
    engine = thrown([*laws, glow], threads=2, observe=["bodies.glow"])
    engine.step(50, 1e-3)
    assert engine.report() and engine.checkpoint() and engine.get("bodies", "glow").tolist() == [1, 1]


def interrupted(engine, steps):
    """Presses Ctrl-C in a while, and says how long the call took to notice."""
    pressed = []

    def press():
        pressed.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.3, press)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            engine.step(steps, 1e-6)
        return time.perf_counter() - pressed[0]
    finally:
        timer.cancel()


@pytest.mark.parametrize("lend", [False, True])
def test_control_c_ends_a_long_call(lend):
    bodies = {"position": np.array([[0.0, 0, 0], [1, 0, 0]]), "velocity": np.zeros((2, 3)), "mass": np.ones(2)}
    engine = vesper.Engine(domains={"bodies": bodies}, laws=["motion", "gravity"], lend=lend)
    assert interrupted(engine, 10**12) < 1
    steps = engine.steps
    assert 0 < steps < 10**12
    engine.step(1, 1e-6)
    assert engine.steps == steps + 1
    # In a frame, too.
    framed = vesper.Engine(domains={"bodies": bodies}, laws=["motion", "gravity"], step=1e-9)
    timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        framed.advance(1e5)
    assert 0 < framed.steps < 10**14


def test_control_c_in_a_law_is_an_exception_as_any_other():
    slow = vesper.Law(lambda velocity: (time.sleep(1e-3), 0 * velocity)[1], adds="force", name="slow")
    engine = thrown([slow])
    assert interrupted(engine, 10**6) < 1
    steps = engine.steps
    engine.step(1, 1e-3)
    assert engine.steps == steps + 1


def test_an_integrator_that_chooses_its_steps_ends_too():
    broken, calls = breaks(30)
    engine = thrown([broken], integrator="dormand_prince_8")
    with pytest.raises(KeyError, match="no more"):
        engine.step(100, 1e-3)
    assert len(calls) == 31
    assert np.isfinite(engine.get("bodies", "position")).all()
    calls.clear()
    engine.step(1, 1e-3)


def test_several_results_have_names():
    both = vesper.Law(lambda velocity: (0, 0), adds="force", sets="glow", name="both")
    engine = thrown([both])
    with pytest.raises(vesper.Fault, match="law both returns tuple: return a dict with force, glow"):
        engine.step(1, 1e-3)


@pytest.mark.parametrize(
    "returned, text",
    [
        (np.zeros((3, 3)), r"law wrong returns an array of shape \(3, 3\) for force: return numbers of shape \(2, 3\)"),
        (None, "law wrong returns NoneType for force"),
        ("much", "law wrong returns str for force"),
    ],
)
def test_what_a_function_returns_has_to_fit(returned, text):
    wrong = vesper.Law(lambda velocity: returned, adds="force", name="wrong")
    with pytest.raises(vesper.Fault, match=text):
        thrown([wrong]).step(1, 1e-3)


def test_a_law_has_to_give_something_that_there_is():
    with pytest.raises(vesper.Fault, match="law idle gives nothing"):
        vesper.Law(lambda velocity: velocity, name="idle")
    with pytest.raises(vesper.Fault, match="mas"):
        thrown([vesper.Law(lambda mas: mas, adds="force", name="slip")])


def test_a_law_may_not_ask_its_own_engine():
    asked = vesper.Law(lambda velocity: engine.get("bodies", "velocity"), adds="force", name="asked")
    engine = thrown([asked])
    with pytest.raises(vesper.Fault, match="the engine is at work"):
        engine.step(1, 1e-3)


def test_arrays_that_a_function_keeps_stay_as_they_were():
    kept = []
    keeper = vesper.Law(lambda position: (kept.append(position), 0 * position)[1], adds="force", name="keeper")
    engine = thrown([keeper])
    engine.step(5, 1e-3)
    del engine
    gc.collect()
    assert kept[0][0, 0] == 0 and kept[-1][0, 0] > 0


def test_a_circle_of_engine_and_law_is_freed():
    box = []
    law = vesper.Law(lambda velocity, box=box: 0 * velocity, adds="force", name="circle", reads=["velocity"])
    engine = thrown([law])
    box.append(engine)
    gone = weakref.ref(engine)
    del engine, law, box
    gc.collect()
    assert gone() is None
