"""What tests of FMUs share: an FMU in a folder, and instances of it as a host makes them."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import byref
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Slave
from fmpy.logging import addLoggerProxy

from otolith.export.fmu_binary import COMPILERS

COMPILER = next((name for name in COMPILERS if shutil.which(name)), None)
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler (cc, gcc, clang) on this machine")
VERSIONS = ("2.0", "3.0")


class Host:
    """One instance of an FMU, called in the same way whatever version it has, and what it said."""

    def __init__(self, folder: Path, name: str = "one") -> None:
        self.description = fmpy.read_model_description(str(folder))
        self.said: list[str] = []
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        slave = FMU2Slave if self.description.fmiVersion == "2.0" else FMU3Slave
        self.fmu: Any = slave(
            guid=self.description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=name,
        )

    def instantiate(self) -> None:
        if isinstance(self.fmu, FMU2Slave):
            callbacks = fmi2CallbackFunctions()
            callbacks.logger = fmi2CallbackLoggerTYPE(self._logged2)
            addLoggerProxy(byref(callbacks))  # which fills in the values of the message, as C does
            self.fmu.instantiate(callbacks=callbacks, loggingOn=True)
        else:
            self.fmu.instantiate(loggingOn=True, logMessage=self._logged3)

    def _logged2(self, _env: Any, _name: bytes, _status: int, _category: bytes, message: bytes) -> None:
        self.said.append(message.decode())

    def _logged3(self, _env: Any, _status: int, _category: bytes, message: bytes) -> None:
        self.said.append(message.decode())

    def start(self, at: float = 0.0) -> None:
        """Go through the initialization."""
        if isinstance(self.fmu, FMU2Slave):
            self.fmu.setupExperiment(startTime=at)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=at)
        self.fmu.exitInitializationMode()

    def set(self, name: str, value: float) -> None:
        setter = self.fmu.setReal if isinstance(self.fmu, FMU2Slave) else self.fmu.setFloat64
        setter([self.references[name]], [value])

    def get(self, name: str) -> float:
        getter = self.fmu.getReal if isinstance(self.fmu, FMU2Slave) else self.fmu.getFloat64
        (value,) = getter([self.references[name]])
        return float(value)

    def step(self, at: float, length: float) -> None:
        self.fmu.doStep(currentCommunicationPoint=at, communicationStepSize=length)


@contextmanager
def host(folder: Path) -> Iterator[Host]:
    """Yield an instance that is ready for its first step."""
    made = Host(folder)
    made.instantiate()
    made.start()
    yield made
    made.fmu.terminate()
    made.fmu.freeInstance()
