"""Nothing is copied, and nothing goes while somebody looks at it."""

import gc
import weakref

import numpy as np
import pytest
import vesper


def address(array):
    return array.__array_interface__["data"][0]


def test_lent_arrays_are_used_in_place(two, bodies):
    start = address(bodies["position"])
    engine = two(lend=True)
    assert engine["bodies", "position"] is bodies["position"]
    engine.step(100, 1e-3)
    assert address(bodies["position"]) == start
    assert bodies["position"][1, 1] > 0.09
    bodies["velocity"][:] = 0
    before = bodies["position"].copy()
    engine.step(1, 1e-9)
    assert np.allclose(bodies["position"], before)


def test_lent_or_copied_gives_the_same_bits(two, bodies):
    copied = two()
    copied.advance(0.5)
    lent = two(lend=True)
    lent.advance(0.5)
    assert np.array_equal(copied.get("bodies", "position"), bodies["position"])


def test_some_columns_may_be_lent(two, bodies):
    engine = two(lend=["bodies.position"])
    assert engine["bodies", "position"] is bodies["position"]
    assert engine["bodies", "velocity"].x.base is not None


def test_the_engine_keeps_what_is_lent(two, bodies):
    engine = two(lend=True)
    gone = weakref.ref(bodies["position"])
    bodies.clear()
    gc.collect()
    engine.step(10, 1e-3)
    assert gone() is not None and gone()[1, 1] > 0
    del engine
    gc.collect()
    assert gone() is None


def test_columns_of_the_engine_are_seen_in_place(two):
    engine = two()
    position = engine["bodies", "position"]
    for component, again in zip(position, engine["bodies", "position"]):
        assert not component.flags.owndata and not component.flags.writeable
        assert address(component) == address(again)
        assert component.base.engine is engine
    engine.step(100, 1e-3)
    assert position.y[1] > 0.09
    assert np.array_equal(np.asarray(position), engine.get("bodies", "position"))
    mass = engine["bodies", "mass"]
    assert mass.tolist() == [1.0, 1e-3] and not mass.flags.owndata
    with pytest.raises(ValueError):
        mass[0] = 2
    with pytest.raises(ValueError):
        mass.flags.writeable = True


def test_an_array_keeps_its_engine(two):
    engine = two()
    gone, y = weakref.ref(engine), engine["bodies", "position"].y
    del engine
    gc.collect()
    assert gone() is not None and y[0] == 0
    y.base.engine.step(100, 1e-3)
    assert y[1] > 0.09
    del y
    gc.collect()
    assert gone() is None


def test_what_is_written_in_place_is_followed(two):
    ours, theirs = two(), two()
    velocity = ours.writable("bodies", "velocity")
    for engine in (ours, theirs):
        engine.step(10, 1e-3)
    velocity.y[1] = 0.5
    changed = theirs.get("bodies", "velocity")
    changed[1, 1] = 0.5
    theirs["bodies", "velocity"] = changed
    for engine in (ours, theirs):
        engine.step(10, 1e-3)
    assert np.array_equal(ours.get("bodies", "position"), theirs.get("bodies", "position"))


def test_rows_do_not_move_under_an_array(two):
    engine = two()
    seen = engine["bodies", "position"]
    new = {"position": [[5, 0, 0]], "velocity": 0, "mass": 1}
    changes = [
        lambda: engine.add_rows("bodies", new),
        lambda: engine.remove_rows("bodies", [0]),
        lambda: engine.enable("gravity", False),
        lambda: engine.observe("bodies", "force"),
        lambda: engine.restore(engine.checkpoint()),
    ]
    for change in changes:
        with pytest.raises(vesper.Fault, match="3 arrays look at in place"):
            change()
    del seen
    for change in changes:
        change()


def test_rows_come_and_go(two):
    engine = two()
    engine.add_rows("bodies", {"position": [[5, 0, 0], [6, 0, 0]], "velocity": 0, "mass": 1})
    engine.step(1, 1e-3)
    assert engine.get("bodies", "position").shape == (4, 3)
    engine.remove_rows("bodies", [0, 2])
    engine.step(1, 1e-3)
    assert engine.shape("bodies", "position") == (2, 3)
    assert engine.get("bodies", "mass").tolist() == [1e-3, 1]


def test_checkpoints_go_on_with_the_same_bits(two):
    engine, other = two(), two()
    engine.step(50, 1e-3)
    other.restore(engine.checkpoint())
    for each in (engine, other):
        each.step(50, 1e-3)
    assert other.steps == 100
    assert np.array_equal(engine.get("bodies", "position"), other.get("bodies", "position"))
