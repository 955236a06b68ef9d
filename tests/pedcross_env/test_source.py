"""The digest of the source: it changes with any line of code and with nothing else."""

import sys

import pytest

from pedcross_env.source import source_digest


def test_a_changed_line_changes_the_digest_and_other_files_do_not(tmp_path, monkeypatch):
    package = tmp_path / "some_package"
    (package / "inner").mkdir(parents=True)
    (package / "__init__.py").write_text("raise RuntimeError('imported')")
    (package / "inner" / "code.py").write_text("A = 1")
    monkeypatch.syspath_prepend(str(tmp_path))

    def digest():
        source_digest.cache_clear()
        return source_digest("some_package")

    first = digest()
    (package / "notes.txt").write_text("no code")
    assert digest() == first
    (package / "inner" / "code.py").write_text("A = 2")
    assert digest() != first
    (package / "inner" / "code.py").rename(package / "code.py")
    moved = digest()
    (package / "code.py").write_text("A = 1")
    assert len({first, moved, digest()}) == 3
    kernels = source_digest("some_package", holding=(b"A = ",))
    (package / "__init__.py").write_text("raise RuntimeError('imported again')")
    source_digest.cache_clear()
    assert source_digest("some_package", holding=(b"A = ",)) == kernels
    assert "some_package" not in sys.modules


def test_the_simulator_is_digested_and_a_package_that_is_not_there_is_named():
    assert source_digest() == source_digest("pedcross_env")
    with pytest.raises(ModuleNotFoundError, match="no_such_package"):
        source_digest("no_such_package")
