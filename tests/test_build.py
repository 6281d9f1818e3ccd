"""The C files of the compiled core, without compiling: which modules go into which."""

import importlib.util
import sys
from pathlib import Path

import pytest

TOOLS = Path(__file__).parents[1] / "tools"


@pytest.fixture(scope="module")
def core_sources():
    """Needs mypyc, which an installation does not bring."""
    pytest.importorskip("mypyc.build")
    specification = importlib.util.spec_from_file_location("core_sources", TOOLS / "core_sources.py")
    module = importlib.util.module_from_spec(specification)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(TOOLS))
        specification.loader.exec_module(module)
    sys.modules.pop("compiled_docstrings", None)
    return module


@pytest.fixture
def names(core_sources, monkeypatch):
    """The names that mypyc gives to the C of the modules."""
    monkeypatch.chdir(TOOLS.parent)
    modules = [Path(path).with_suffix("").parts for path in core_sources.modules_of_core()]
    return [f"__native_{'___'.join(parts)}.c" for parts in modules]


def test_every_group_of_modules_still_exists(core_sources, names):
    modules = [name.removeprefix(core_sources.PREFIX) for name in names]
    for beginnings in core_sources.UNITS.values():
        assert [one for one in beginnings if not any(module.startswith(one) for module in modules)] == []


@pytest.mark.parametrize(
    ("module", "unit"),
    [
        ("algebra", "filters"),
        ("filters___velocity_aided___covariance", "filters"),
        ("filters___registry", "setting up"),
        ("filters___velocity_aided___alignment___solve", "setting up"),
        ("estimation___alignment", "estimation"),
        ("estimate", "records"),
        ("vehicle_settings", "records"),
        ("logs___tlog___reader", "logs"),
    ],
)
def test_modules_that_call_each_other_at_every_sample_share_a_file(core_sources, names, module, unit):
    name = f"__native_attest_mav___{module}.c"
    assert name in names
    assert core_sources.unit_of(name) == unit


def test_the_tables_of_all_modules_and_the_run_time_have_their_places(core_sources):
    assert core_sources.unit_of("__native_8850fc19048d7ab62355.c") == "tables"
    assert core_sources.unit_of("int_ops.c") == "filters"
