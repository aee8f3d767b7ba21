"""The notebooks of the documentation run, and their own assertions hold."""

import pytest

pytestmark = pytest.mark.filterwarnings("default")

NAMES = ["pendulum", "tuning_fork", "map", "batch"]


def test_all_notebooks_are_known(root):
    assert sorted(path.stem for path in (root / "docs/notebooks").glob("*.ipynb")) == sorted(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_notebook_runs(root, name):
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    folder = root / "docs/notebooks"
    notebook = nbformat.read(folder / f"{name}.ipynb", as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "outputs are not kept: they would go stale"
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(folder)}}).execute()
    pictures = [
        output
        for cell in notebook.cells
        for output in cell.get("outputs", [])
        if "image/png" in output.get("data", {})
    ]
    assert pictures, "a notebook without a picture"
