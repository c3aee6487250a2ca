"""The reference has an entry for everything that a configuration can name, and each entry says something."""

import importlib
import inspect
import pkgutil
import sys
from pathlib import Path

import pytest

import lift_lab
import lift_lab_assets
import lift_lab_cli
import lift_lab_rl
import lift_lab_tasks
from lift_lab.isaac.finder import MODULES
from lift_lab.utils.configclass import ConfigBase
from lift_lab_tasks.utils import load_cfg_from_registry, registered_tasks, task_kwargs

griffe = pytest.importorskip("griffe", reason="mkdocstrings is not installed (the extra 'docs')")
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts" / "maintainers"))
docs_reference, docs_rst = map(importlib.import_module, ("docs_reference", "docs_rst"))

PACKAGES = (lift_lab, lift_lab_assets, lift_lab_rl, lift_lab_tasks, lift_lab_cli)


def path_of(value) -> str:
    return f"{value.__module__}.{value.__qualname__}"


def ours(value) -> bool:
    """A class or function of these packages that works: the names of Isaac Lab that are refused have no entry."""
    if not (inspect.isclass(value) or inspect.isfunction(value)) or not value.__module__.startswith("lift_lab"):
        return False
    outer = value.__qualname__.split(".")[0]
    return "<" not in outer and outer not in MODULES.get(value.__module__, {}) and ".isaac." not in value.__module__


@pytest.fixture(scope="module")
def modules():
    found = {}
    for package in PACKAGES:
        for info in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not any(part.startswith("_") for part in info.name.split(".")):
                found[info.name] = importlib.import_module(info.name)
    return found


@pytest.fixture(scope="module")
def entries():
    """Path of each documented object."""
    return {o.path: o for page in docs_reference.sections().values() for s in page for o in s.names.values()}


def missing(values, entries) -> list[str]:
    """Paths without an entry. A class within a class is part of the outer one's entry."""
    outer = {path_of(value).removesuffix(value.__qualname__) + value.__qualname__.split(".")[0] for value in values}
    return sorted(outer - set(entries))


def test_everything_in_the_configurations_of_the_tasks_has_an_entry(entries):
    named, seen = set(), {}

    def walk(value):
        if inspect.isclass(value) or inspect.isfunction(value):
            named.update([value] if ours(value) else [])
        elif id(value) not in seen:
            seen[id(value)] = value
            if isinstance(value, (dict, list, tuple, set)):
                for part in value.values() if isinstance(value, dict) else value:
                    walk(part)
            elif type(value).__module__.startswith("lift_lab"):
                walk(type(value))
                for part in vars(value).values():
                    walk(part)

    for task in registered_tasks():
        for key in task_kwargs(task):
            if key.endswith("_cfg_entry_point"):
                walk(load_cfg_from_registry(task, key))
    assert len(named) > 150
    assert missing(named, entries) == []


def test_every_configuration_class_has_an_entry(modules, entries):
    found = [ConfigBase]
    for each in found:
        found += each.__subclasses__()
    found = [each for each in found if ours(each) and each.__module__ in modules]
    assert len(found) > 150
    assert missing(found, entries) == []


def test_every_class_and_function_that_a_package_exports_has_an_entry(modules, entries):
    exported = {
        getattr(module, name)
        for module in modules.values()
        if hasattr(module, "__path__")
        for name in getattr(module, "__all__", ())
        if name != "mdp"
        if ours(getattr(module, name))
    }
    assert len(exported) > 400
    assert missing(exported, entries) == []


def test_every_term_has_an_entry(modules, entries):
    terms = {
        value
        for name, module in modules.items()
        if ".mdp" in name and name != "lift_lab.envs.mdp.sampling"
        for attribute, value in vars(module).items()
        if ours(value) and value.__module__ == name and attribute in getattr(module, "__all__", [attribute])
        if not attribute.startswith("_")
    }
    assert len(terms) > 100
    assert missing(terms, entries) == []


def test_every_entry_has_a_docstring(modules, entries):
    silent = [path for path, each in entries.items() if not each.docstring]
    for path in entries:
        module, _, name = path.rpartition(".")
        value = getattr(modules.get(module), name, None)
        if inspect.isclass(value):
            methods = [method for method, of in vars(value).items() if inspect.isfunction(of) and method[0] != "_"]
            silent += [f"{path}.{method}" for method in methods if not inspect.getdoc(getattr(value, method))]
    assert silent == []


def test_the_navigation_has_every_page_once_and_names_are_on_one_page_only(entries):
    linked = [
        file
        for _, pages in (item for group in docs_reference.nav()[1:] for item in group.items())
        for page in pages
        for file in page.values()
    ]
    assert sorted([*linked, "api/index.md"]) == sorted(docs_reference.files())
    counts = [len(s.names) for page in docs_reference.sections().values() for s in page]
    assert sum(counts) == len(entries)


def test_blocks_of_code_in_docstrings_become_markdown():
    text = (
        "First.\n\n.. code-block:: python\n\n    x = 1\n\n    if x:\n        y = 2\n\nAs :math:`q_1` in::\n\n    a::b"
    )
    assert docs_rst.to_markdown(text) == (
        "First.\n\n```python\nx = 1\n\nif x:\n    y = 2\n```\n\nAs `q_1` in:\n\n    a::b"
    )


def test_cached_values_of_assets_are_shown_as_properties():
    extensions = griffe.load_extensions(docs_rst.Rst)
    options = {"search_paths": [Path(lift_lab.__file__).parents[1]], "extensions": extensions}
    data = griffe.load("lift_lab.assets.body_state", **options)
    found = [cls.members["root_ang_vel_b"] for cls in data.classes.values() if "root_ang_vel_b" in cls.members]
    assert found
    assert all(isinstance(member, griffe.Attribute) and member.docstring for member in found)
