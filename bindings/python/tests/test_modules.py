"""Laws of modules, and what becomes of arrays in place when one fails while it runs."""

import gc
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import vesper

HEADER = Path(__file__).parents[2] / "c" / "include"
# Fails in its third evaluation, so that a step or two was taken before.
WRONG = r"""
#include "vesper_law.h"
static int calls;
static int32_t create(const vesper_host *host, const double *p, size_t n, void **self) {
    (void)p, (void)n; *self = (void *)host; calls = 0; return 0;
}
static int32_t apply(void *self, const vesper_call *call) {
    (void)self, (void)call; return ++calls > 2 ? 7 : 0;
}
static const vesper_port ports[] = {{.property = "mass", .si = {0, 1}, .kind = 1, .mode = VESPER_READS},
    {.property = "force", .si = {1, 1, -2}, .kind = 3, .mode = VESPER_ADDS}};
static const vesper_law law = {.struct_size = sizeof(vesper_law), .port_size = sizeof *ports,
    .parameter_size = sizeof(vesper_parameter), .shape = VESPER_ROWS, .precisions = VESPER_LAW_F64, .name = "wrong",
    .port_count = 2, .ports = ports, .create = create, .apply = apply};
static const vesper_law *const laws[] = {&law};
static const vesper_module module = {VESPER_LAW_ABI, sizeof module, 0, 1, laws};
const vesper_module *vesper_module_v1(void) { return &module; }
"""


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    if shutil.which("cc") is None:
        pytest.skip("there is no compiler of C")
    folder = tmp_path_factory.mktemp("modules")
    (folder / "wrong.c").write_text(WRONG)
    out = ["-o", folder / "libfailing.so", folder / "wrong.c"]
    subprocess.run(["cc", "-std=c99", "-O2", "-shared", "-fPIC", "-I", HEADER, *out], check=True)
    return folder


def failing(folder, **more):
    # Enough rows that memory which is freed goes back to the system: whoever looks there then crashes.
    rows = 100_000
    place = np.zeros((rows, 3))
    place[:, 0] = np.arange(rows)
    bodies = {"position": place, "velocity": np.ones((rows, 3)), "mass": np.ones(rows)}
    laws = ["motion", {"name": "wrong", "module": "failing"}]
    return vesper.Engine(domains={"bodies": bodies}, laws=laws, laws_from=folder, step=1e-3, **more)


def fails(engine):
    with pytest.raises(vesper.StepFault, match="wrong failed and is switched off: `apply` returned 7"):
        for _ in range(9):
            engine.step(1, 1e-3)


def test_arrays_stay_when_a_law_fails(folder):
    engine = failing(folder)
    seen = engine["bodies", "position"]
    fails(engine)
    # The step was taken, without the law.
    steps = engine.steps
    assert steps > 0 and seen.x[5] == pytest.approx(5 + engine.time)
    before = seen.x.copy()
    for move in (
        lambda: engine.step(1, 1e-3),
        lambda: engine.advance(1e-3),
        lambda: engine["bodies", "velocity"],
        lambda: engine.rows("bodies", "position"),
        lambda: engine.report(),
        lambda: engine.explain(),
        lambda: engine.dot(),
    ):
        with pytest.raises(vesper.Fault, match="would move columns that 3 arrays look at in place, since laws"):
            move()
    assert engine.steps == steps
    _ = [np.full(100_000, 7.0) for _ in range(20)]
    assert np.array_equal(seen.x, before)
    del seen
    gc.collect()
    engine.step(2, 1e-3)
    assert engine.steps == steps + 2 and "wrong" in engine.report()
    again = engine["bodies", "position"]
    engine.step(1, 1e-3)
    assert again.x[5] == pytest.approx(5 + engine.time)


def test_a_law_that_fails_ends_a_call_of_many_steps(folder):
    engine = failing(folder)
    with pytest.raises(vesper.StepFault, match="wrong failed") as fault:
        engine.step(1000, 1e-3)
    assert "not be taken" not in str(fault.value)
    assert 0 < engine.steps < 1000
    assert engine.get("bodies", "position")[5, 0] == pytest.approx(5 + engine.time)
    engine.step(10, 1e-3)


def test_modules_are_found_by_their_folder_or_the_environment(folder, monkeypatch):
    monkeypatch.setenv("VESPER_LAW_PATH", str(folder))
    assert "wrong" in failing(()).report()
    monkeypatch.delenv("VESPER_LAW_PATH")
    with pytest.raises(vesper.Fault, match="failing"):
        failing(())
    assert "wrong" in failing([str(folder)]).report()
    with pytest.raises(vesper.Fault, match="there is no folder .* with modules of laws"):
        failing(folder / "nowhere")
