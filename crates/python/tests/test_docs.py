"""The documentation of the package: its examples, and that everything has some."""

import doctest
import inspect

import trochoid


def test_examples_hold(scene):
    """One folder for all examples, since one takes the files of another."""
    water = (scene / "water.json").read_text()
    (scene / "water.json").write_text(water.replace('"last": 3', '"last": 1'))
    runner = doctest.DocTestRunner()
    for name in ["Look", "check", "render", "palette", "decompose", "recolor", "plan", "run"]:
        found = doctest.DocTestFinder(recurse=False).find(
            getattr(trochoid, name), name, module=False, globs={"trochoid": trochoid}
        )
        assert found and found[0].examples, f"{name} has no example"
        for test in found:
            runner.run(test)
    assert runner.failures == 0


def test_everything_is_documented():
    for name in trochoid.__all__:
        value = getattr(trochoid, name)
        if name == "__version__":
            continue
        assert value.__doc__, f"{name} has no documentation"
        if inspect.isclass(value) and not issubclass(value, Exception):
            for member, found in vars(value).items():
                if not member.startswith("_"):
                    assert inspect.getdoc(found), f"{name}.{member} has no documentation"
