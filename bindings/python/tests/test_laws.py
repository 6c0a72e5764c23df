"""Functions as laws."""

import gc
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


def test_an_exception_comes_through_and_nothing_has_moved():
    calls = []

    @vesper.law(adds="force")
    def broken(velocity):
        calls.append(velocity)
        if len(calls) > 20:
            raise KeyError("no more")
        return 0 * velocity

    engine = thrown([broken])
    before = engine.get("bodies", "position")
    with pytest.raises(KeyError, match="no more"):
        engine.step(100, 1e-3)
    assert len(calls) == 21
    assert np.array_equal(engine.get("bodies", "position"), before) and engine.steps == 0
    calls.clear()
    engine.step(5, 1e-3)
    assert engine.steps == 5


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
