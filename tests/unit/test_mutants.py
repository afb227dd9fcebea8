"""Each mutant still fits the file that it breaks, and names a test that exists."""

import pytest

from tests.environment import ROOT
from tests.mutants import MUTANTS


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.what)
def test_it_fits_its_file(mutant):
    assert (ROOT / mutant.path).read_text().count(mutant.old) == 1
    assert mutant.new != mutant.old
    file, _, name = mutant.test.partition("::")
    assert (ROOT / file).exists()
    assert name.partition("[")[0].rpartition("::")[2] in (ROOT / file).read_text()
