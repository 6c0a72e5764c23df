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


def test_what_the_engine_says_does_not_move_what_is_seen(two):
    engine = two()
    seen = engine["bodies", "position"]
    assert "gravity" in engine.report() and engine.explain() and engine.dot().startswith("digraph")
    engine.step(100, 1e-3)
    assert seen.y[1] > 0.09 and address(seen.y) == address(engine["bodies", "position"].y)


@pytest.mark.parametrize("shrinks", [True, False])
def test_lent_memory_that_was_resized_is_not_touched(two, bodies, shrinks):
    engine = two(lend=True)
    engine.step(1, 1e-3)
    bodies["position"].resize((1, 3) if shrinks else (200_000, 3), refcheck=False)
    calls = [
        lambda: engine.step(1, 1e-3),
        lambda: engine.advance(1e-3),
        lambda: engine.get("bodies", "position"),
        lambda: engine.__setitem__(("bodies", "position"), 0.0),
        lambda: engine.checkpoint(),
        lambda: engine.report(),
        lambda: engine.observe("bodies", "force"),
        lambda: engine["bodies", "position"],
        lambda: engine.writable("bodies", "position"),
        lambda: engine.rows("bodies", "position"),
        lambda: engine.shape("bodies", "position"),
        lambda: engine.kind("bodies", "position"),
    ]
    for call in calls:
        with pytest.raises(vesper.Fault, match="bodies.position is lent, and the array was resized since"):
            call()
    assert engine.steps == 1


def test_lent_memory_that_is_a_part_of_what_was_resized_is_not_touched(bodies):
    whole = np.zeros((4, 3))
    bodies["position"] = whole[1:3]
    bodies["position"][1, 0] = 1
    engine = vesper.Engine(domains={"bodies": bodies}, laws=["motion"], lend=True)
    engine.step(1, 1e-3)
    whole.resize((100_000, 3), refcheck=False)
    with pytest.raises(vesper.Fault, match="the array was resized since"):
        engine.step(1, 1e-3)


def test_lent_memory_that_became_read_only_is_not_written(two, bodies):
    engine = two(lend=True)
    bodies["velocity"].flags.writeable = False
    before = bodies["velocity"].copy()
    with pytest.raises(vesper.Fault, match="bodies.velocity is lent, and the array was made read-only since"):
        engine.step(1, 1e-3)
    assert np.array_equal(bodies["velocity"], before) and engine.steps == 0
    bodies["velocity"].flags.writeable = True
    engine.step(1, 1e-3)


def test_lent_memory_is_looked_at_when_the_engine_is_built(bodies):
    assembly = vesper._vesper.Assembly("f64")
    assembly.domain("bodies", 2)
    assembly.lend("bodies", "position", bodies["position"])
    bodies["position"].resize((1, 3), refcheck=False)
    with pytest.raises(vesper.Fault, match="bodies.position is lent, and the array was resized since"):
        vesper._vesper.Engine(assembly)


def test_copies_go_to_rows_that_stand_one_behind_the_other(two):
    engine = two()
    into = np.zeros((2, 3))
    engine.copy_to("bodies", "position", into)
    assert into.tolist() == [[0, 0, 0], [1, 0, 0]]
    for wrong in (np.zeros((2, 3), order="F"), np.zeros((4, 3))[::2], np.zeros((2, 6))[:, :3]):
        with pytest.raises(vesper.Fault, match="bodies.position: the numbers of its rows do not stand one behind the other"):
            engine.copy_to("bodies", "position", wrong)
        assert not wrong.any()
    into.flags.writeable = False
    with pytest.raises(vesper.Fault, match="read-only"):
        engine.copy_to("bodies", "position", into)


@pytest.mark.parametrize("first", [0, 1, 2])
@pytest.mark.parametrize("unit", ["", " [km]"])
def test_memory_that_overlaps_a_column_gives_the_numbers_of_a_copy(bodies, first, unit):
    whole = np.arange(12.0).reshape(4, 3)
    position, other = whole[1:3], whole[first : first + 2]
    bodies["position"] = position
    engine = vesper.Engine(domains={"bodies": bodies}, laws=["motion"], lend=["bodies.position"])
    factor = 1000 if unit else 1
    expected = other * factor
    engine["bodies", "position" + unit] = other
    assert np.array_equal(position, expected)
    whole[:] = np.arange(12.0).reshape(4, 3)
    expected = position / factor
    engine.copy_to("bodies", "position" + unit, other)
    assert np.array_equal(other, expected)
    whole[:] = np.arange(12.0).reshape(4, 3)
    expected = position[::-1, ::-1].copy()
    engine["bodies", "position"] = position[::-1, ::-1]
    assert np.array_equal(position, expected)


def test_columns_are_written_and_copied_in_other_units(two):
    engine = two()
    engine["bodies", "velocity [km/s]"] = [[0, 0, 0], [0, 2, 0]]
    assert engine.get("bodies", "velocity")[1, 1] == 2000
    assert engine.get("bodies", "velocity [km/s]")[1, 1] == 2
    with pytest.raises(vesper.Fault, match="ask without a unit, or have it copied"):
        engine["bodies", "velocity [km/s]"]


@pytest.mark.parametrize("place", [0.0, 1e6])
def test_columns_with_an_origin_that_moves_are_copied_only(place):
    place = np.array([[place, 0, 0], [place + 1, 0, 0]])
    bodies = {"position": place, "velocity": np.full((2, 3), 7.0), "mass": [1, 1]}
    engine = vesper.Engine(domains={"bodies": bodies}, laws=["motion", ("gravity", {"g": 1e-3})], moving_origin=True, step=1e-3)
    for look in (lambda: engine["bodies", "position"], lambda: engine.writable("bodies", "position [m]")):
        with pytest.raises(vesper.Fault, match=r"measured from an origin that moves with it.*take engine.get"):
            look()
    assert engine["bodies", "velocity"].x[0] == 7
    assert np.allclose(engine.get("bodies", "position"), place, rtol=1e-15)
    engine.step(3000, 1e-3)
    assert np.allclose(engine.get("bodies", "position").mean(axis=0), place.mean(axis=0) + 21)
    with pytest.raises(vesper.Fault, match="position does not let the origin move"):
        vesper.Engine(domains={"bodies": bodies}, laws=["motion"], moving_origin=True, lend=["bodies.position"])


def test_a_circle_through_an_array_stays_until_it_is_cut(two):
    # numpy does not tell the collector what an array looks into: the README says so.
    engine = two()
    gone = weakref.ref(engine)
    engine.view = engine["bodies", "mass"]
    del engine
    gc.collect()
    assert gone() is not None
    del gone().view
    gc.collect()
    assert gone() is None


@pytest.mark.parametrize(
    "lend, text",
    [
        (["bodies.positon"], r"'bodies.positon' cannot be lent: no column is named so; did you mean bodies.position\?"),
        (["position"], r"'position' cannot be lent: no column is named so; did you mean bodies.position\?"),
        ("bodies.mas", r"'bodies.mas' cannot be lent: no column is named so; did you mean bodies.mass\?"),
        (["bodies.mass"], "bodies.mass cannot be lent: it is a list: give an array of numpy"),
        (["bodies.age"], "bodies.age cannot be lent: it is a ndarray|bodies.age cannot be lent: it is a"),
        (["bodies.position", 3], "3 cannot be lent: no column is named so"),
    ],
)
def test_each_column_that_is_named_to_be_lent_is_there(two, bodies, lend, text):
    bodies["age"] = np.array(3.0)
    if text.startswith("bodies.mass"):
        bodies["mass"] = [1.0, 1e-3]
    with pytest.raises(vesper.Fault, match=text):
        two(lend=lend)


@pytest.mark.parametrize("lend", ["bodies.position", ["bodies.position [m]"], ("bodies.position",), {"bodies.position"}])
def test_a_column_is_lent_by_its_name(two, bodies, lend):
    bodies["position [m]"] = bodies.pop("position")
    engine = two(lend=lend)
    assert engine["bodies", "position"] is bodies["position [m]"]
    assert engine["bodies", "velocity"].x.base is not None


@pytest.mark.parametrize("integrator", ["leapfrog", "runge_kutta_4", "gauss_radau_15", "dormand_prince_8", "implicit_midpoint", "auto"])
@pytest.mark.parametrize("compensated", [False, True])
def test_pieces_of_a_call_change_no_bit(two, integrator, compensated):
    more = {"integrator": integrator, "compensated": compensated}
    one, other = two(**more), two(**more)
    one.step(3000, 1e-3)
    for _ in range(300):
        other.step(10, 1e-3)
    assert one.steps == other.steps == 3000
    assert np.array_equal(one.get("bodies", "position"), other.get("bodies", "position"))
    framed, stepped = two(**more), two(**more)
    framed.advance(3.0)
    # An integrator that chooses its steps takes a frame as one.
    adaptive = integrator in ("gauss_radau_15", "dormand_prince_8", "auto")
    stepped.step(1, 3.0) if adaptive else stepped.step(3000, 1e-3)
    assert framed.steps == stepped.steps == (1 if adaptive else 3000)
    assert np.array_equal(framed.get("bodies", "position"), stepped.get("bodies", "position"))


def test_pieces_of_lent_arrays_are_the_same_in_each_run(two, bodies):
    kept = {name: array.copy() for name, array in bodies.items()}
    ends = []
    for _ in range(2):
        for name, array in kept.items():
            bodies[name] = array.copy()
        engine = two(lend=True, integrator="gauss_radau_15")
        engine.step(10_000, 1e-3)
        ends.append(bodies["position"].copy())
    assert np.array_equal(*ends)
