"""What does not fit is an exception that says what to do."""

import threading

import numpy as np
import pytest
import vesper


@pytest.mark.parametrize(
    "column, given, text",
    [
        ("position", np.zeros((2, 3), np.float32), r"position cannot be lent: it is an array of float32.*astype\(np.float64\)"),
        ("position", np.zeros((2, 3), int), r"array of int64.*astype\(np.float64\)"),
        ("position", np.zeros((3, 2)).T, r"np.ascontiguousarray"),
        ("position", np.zeros((4, 3))[::2], r"np.ascontiguousarray"),
        ("position", np.zeros((2, 2)), r"position has 4 numbers, but 2 rows of a vector are 6"),
        ("position", np.broadcast_to(np.zeros(1), (2, 3)), r"ascontiguousarray|read-only"),
        ("velocity [km/s]", np.zeros((2, 3)), r"cannot be lent: it is used as it is, in m/s"),
    ],
)
def test_what_cannot_be_lent(two, bodies, column, given, text):
    bodies.pop("velocity" if "velocity" in column else "position")
    bodies[column] = given
    with pytest.raises(vesper.Fault, match=text):
        two(lend=True)


def test_read_only_memory_is_not_written(two, bodies):
    bodies["position"].flags.writeable = False
    with pytest.raises(vesper.Fault, match="position is read-only"):
        two(lend=True)


def test_memory_is_lent_once(two, bodies):
    bodies["velocity"] = bodies["position"]
    with pytest.raises(vesper.Fault, match="bodies.position has some of the same memory"):
        two(lend=True)


@pytest.mark.parametrize(
    "more, text",
    [
        ({"laws": ["gravitee"]}, "gravitee"),
        ({"laws": [("gravity", {"softning": 1.0})]}, "did you mean `softening`"),
        ({"laws": [3]}, "a law is 3"),
        ({"laws": [("gravity", {"g": None})]}, "law gravity, g is a NoneType"),
        ({"integrator": "leapfrog!"}, "no integrator is named"),
        ({"steps": 1}, "steps"),
        ({"precision": "f16"}, 'no precision is named `f16`: take "f32" or "f64"'),
    ],
)
def test_what_is_not_known(two, more, text):
    with pytest.raises(vesper.Fault, match=text):
        two(**more)


def test_columns_have_as_many_rows_each(two, bodies):
    bodies["mass"] = [1, 2, 3]
    with pytest.raises(vesper.Fault, match="position has 2, mass has 3"):
        two()


def test_columns_that_are_not_there(two):
    engine = two()
    with pytest.raises(vesper.Fault, match="position"):
        engine["bodies", "positon"]
    with pytest.raises(vesper.Fault, match="bodies"):
        engine["bodys", "position"]
    with pytest.raises((TypeError, vesper.Fault)):
        engine["position"]
    with pytest.raises(vesper.Fault, match=r"shape \(2, 3\), and not \(3, 3\)"):
        engine["bodies", "position"] = np.zeros((3, 3))
    with pytest.raises(vesper.Fault, match="row 0 is NaN|finite"):
        engine["bodies", "position"] = np.full((2, 3), np.nan)


def test_steps_that_cannot_be_taken(two, bodies):
    engine = two()
    with pytest.raises(vesper.StepFault, match="the step"):
        engine.step(1, -1.0)
    with pytest.raises(vesper.StepFault, match="the frame"):
        engine.advance(float("nan"))
    with pytest.raises(OverflowError):
        engine.step(-1, 1e-3)
    lent = two(lend=True)
    bodies["velocity"][:] = np.inf
    with pytest.raises(vesper.StepFault, match="inf|NaN"):
        lent.step(1, 1e-3)


def test_two_threads_are_never_inside_one_engine(two):
    engine = two()
    begun, refused = threading.Event(), []

    def work():
        begun.set()
        try:
            engine.step(2_000_000, 1e-6)
        except vesper.Fault as fault:
            refused.append(str(fault))

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    begun.wait()
    looks = 0
    while any(thread.is_alive() for thread in threads):
        looks += 1
        try:
            engine.time
        except vesper.Fault as fault:
            refused.append(str(fault))
    # Python went on while the engine was at work, and was told so.
    assert looks > 1 and refused
    assert all("the engine is at work" in text for text in refused)
    engine.step(1, 1e-3)


def test_scenes_come_from_texts_and_files(tmp_path):
    scene = """
[engine]
step = 0.001
precision = "f32"
[domains.bodies]
position = [[0.0, 0.0, 10.0]]
velocity = [[0.0, 0.0, 0.0]]
mass = [1.0]
[constants]
gravity = [0.0, 0.0, -9.81]
[[laws]]
name = "motion"
[[laws]]
name = "uniform_gravity"
"""
    path = tmp_path / "fall.toml"
    path.write_text(scene)
    for engine in (vesper.Engine.from_scene(scene), vesper.Engine.from_scene(path), vesper.Engine.from_scene(str(path))):
        assert engine.precision == "f32"
        engine.advance(1.0)
        assert engine.get("bodies", "position")[0, 2] == pytest.approx(10 - 0.5 * 9.81, rel=1e-4)
    with pytest.raises(vesper.Fault, match=r"scene:\d+:\d+"):
        vesper.Engine.from_scene(scene.replace("uniform_gravity", "uniform_gravitee"))
    assert "uniform_gravity" in engine.report() and "digraph" in engine.dot() and engine.explain()


def test_one_law_with_parameters_is_a_law(two):
    engine = two(laws=("gravity", {"g": 2.0}))
    assert "gravity" in engine.report()
    with pytest.raises(vesper.Fault, match="did you mean `softening`"):
        two(laws=("gravity", {"softning": 2.0}))
    # Two laws, the second of which has a name, are two.
    assert "motion" in two(laws=("gravity", {"name": "motion"})).report()


def test_any_mapping_is_a_table(two, bodies):
    from types import MappingProxyType

    bodies = MappingProxyType(bodies)
    laws = ["motion", ("gravity", MappingProxyType({"g": 1.0})), MappingProxyType({"name": "gravity", "label": "twice"})]
    integrator = MappingProxyType({"name": "dormand_prince_8", "rtol": 1e-9})
    engine = vesper.Engine(domains=MappingProxyType({"bodies": bodies}), laws=laws, integrator=integrator)
    assert "twice" in engine.report()


def test_scenes_make_engines_of_the_class_that_is_asked():
    class Mine(vesper.Engine):
        pass

    assert type(Mine.from_scene("[engine]\nstep = 1.0\n")) is Mine
