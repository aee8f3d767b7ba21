"""The examples of the page on Python run, one after the other."""

import re

import pytest
import slipfit

pytestmark = pytest.mark.filterwarnings("default")


def test_examples_of_the_page_run(root, tmp_path, monkeypatch):
    matplotlib = pytest.importorskip("matplotlib")
    for package in ("pandas", "polars", "pyarrow", "xarray", "uncertainties"):
        pytest.importorskip(package)
    matplotlib.use("agg")
    (tmp_path / "examples").symlink_to(root / "examples")
    monkeypatch.chdir(tmp_path)
    page = (root / "docs/python.md").read_text()
    blocks = list(re.finditer(r"```python\n(.*?)```", page, re.DOTALL))
    assert len(blocks) >= 8
    names = {}
    for block in blocks:
        line = page[: block.start()].count("\n") + 1
        exec(compile("\n" * line + block[1], "docs/python.md", "exec"), names)
    quantity = names["x_f"]
    friction = names["series"].table[0].ringdown.friction
    for text in (f"{quantity:.3g}", f"{quantity:.2u}", f"5 N: {friction:.2u}"):
        assert text in page, text
    assert isinstance(names["found"]["friction_displacement"].attrs["units"], str)
    assert slipfit.fit_batch(names["table"], amplitude="trace", dt=1e-3, unit="nm").units["sliding_rate"] == "nm/s"
    matplotlib.pyplot.close("all")
