"""The manual's drawing of the layers shows each package of the program once, as the import contracts order them."""

from tests.copies import ROOT, docs_module

layers = docs_module("layers")


def test_every_package_is_drawn_once_in_its_layer(tmp_path) -> None:
    names = [name for row in layers.layers() for name in row]
    modules = {path.stem if path.suffix else path.name for path in (ROOT / "compare").glob("*") if is_module(path)}
    assert sorted(names) == sorted({*modules, "lowfi", "hifi", "reports", "meshes"})
    assert names.index("commands") < names.index("report") < names.index("studies") < names.index("models")
    layers.draw(tmp_path / "layers.svg")
    text = (tmp_path / "layers.svg").read_text(encoding="utf-8")
    assert all(f">{name}<" in text for name in names)
    assert "_static/layers.svg" in (ROOT / "docs/inside.md").read_text(encoding="utf-8")


def is_module(path) -> bool:
    return (path / "__init__.py").is_file() or (path.suffix == ".py" and path.stem != "__init__")
