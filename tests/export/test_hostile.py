"""Whatever it is given, a program answers with a status and a finite command; a snapshot goes on alike."""

from pathlib import Path

import numpy as np

from otolith import files
from otolith.compiled import INVALID
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.design import Design
from otolith.export.make import Kind, program_of
from otolith.export.vectors import drive, vectors
from tests.export.in_c import needs_compiler
from tests.export.sanitized import Sanitized, hostile

USED = [0, *range(6, 24)]  # inputs that it reads: one force, and what is measured


@needs_compiler
def test_hostile_inputs_are_answered_by_braking_and_a_snapshot_goes_on_alike(tmp_path: Path) -> None:
    design = Design(platform=files.read_platform("thesis"), dofs=(SURGE_PITCH,))
    program = program_of(design, "predictive", "hostile", Kind.COMMAND)
    plain = vectors(design, "predictive", Kind.COMMAND, drive(6.0)).inputs
    inputs = hostile(plain, seed=4, share=0.3)
    inputs[500:] = plain[500:]
    sanitized = Sanitized(program, tmp_path)
    status, out = sanitized.run(inputs)
    assert np.isfinite(out[:, :6]).all()
    assert np.abs(out[:, 0]).max() <= 5.0
    invalid = ~np.isfinite(inputs[:, USED]).all(axis=1)
    assert np.count_nonzero(invalid) > 50
    assert set(status[invalid]) == {INVALID}
    assert not status[510:].any()  # it decides again
    _, again = sanitized.run(inputs, keep=100, again=300)
    np.testing.assert_array_equal(again[:301], out[:301])
    np.testing.assert_array_equal(again[301:], out[100:])
