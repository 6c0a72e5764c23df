"""The front page runs."""

import re
import traceback
from pathlib import Path

import numpy as np
import pytest

PAGE = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")


def test_the_front_page_runs(capsys):
    first, law = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    scope = {}
    exec(first, scope)
    assert np.allclose(scope["position"][1], [0.54, 0.84, 0], atol=0.005)
    exec(law, scope)
    laws = ["motion", scope["drag"]]
    scope["vesper"].Engine(domains={"bodies": scope["bodies"]}, laws=laws).step(1, 1e-3)


def test_the_fault_on_the_front_page_is_what_python_prints():
    import vesper

    call, expected = re.search(r"`(vesper\.Engine\(laws=[^`]*)` ends in\n\n```text\n(.*?)```", PAGE, re.DOTALL).groups()
    with pytest.raises(vesper.Fault) as raised:
        eval(call, {"vesper": vesper})
    assert "".join(traceback.format_exception_only(raised.value)) == expected
