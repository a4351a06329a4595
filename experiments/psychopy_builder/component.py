"""The Builder component, which PsychoPy finds by its entry point, and the code it generates.

The generated code and the names of methods, parameters and attributes follow PsychoPy.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

from psychopy.experiment.components import BaseDeviceComponent, getInitVals
from psychopy.experiment.devices import DeviceBackend
from psychopy.experiment.params import Param

FOLDER = Path(__file__).parent

START = """\
%(name)s.start()
[%(loop)s.addData('%(name)s.' + column, value) for column, value in %(name)s.columns.items()]
"""
CHECK = "%(name)s.check()\n"
STOP = "%(name)s.stop()\n"


class SlipscalePlateComponent(BaseDeviceComponent):  # type: ignore[misc] # PsychoPy has no types
    """Builder component that makes the plate vibrate while the component is active."""

    categories: ClassVar = ["Stimuli"]
    targets: ClassVar = ["PsychoPy"]
    version = "2026.2.0"
    plugin = "slipscale"
    iconFile = FOLDER / "plate.png"  # noqa: N815 - PsychoPy takes the theme's own from there
    tooltip = "Slipscale plate: vibrate at an amplitude, or at a level in the plate's unit"
    beta = False

    def __init__(
        self,
        exp: Any,
        parentName: str,  # noqa: N803
        name: str = "plate",
        *,
        startType: str = "time (s)",  # noqa: N803
        startVal: float | str = 0.0,  # noqa: N803
        stopType: str = "duration (s)",  # noqa: N803
        stopVal: float | str = "",  # noqa: N803
        startEstim: str = "",  # noqa: N803
        durationEstim: str = "",  # noqa: N803
        deviceLabel: str = "",  # noqa: N803
        amplitude_um_pp: float | str = 1.2,
        saveStartStop: bool = True,  # noqa: N803
        syncScreenRefresh: bool = False,  # noqa: N803
        disabled: bool = False,
    ) -> None:
        super().__init__(
            exp,
            parentName,
            name=name,
            startType=startType,
            startVal=startVal,
            stopType=stopType,
            stopVal=stopVal,
            startEstim=startEstim,
            durationEstim=durationEstim,
            deviceLabel=deviceLabel,
            saveStartStop=saveStartStop,
            syncScreenRefresh=syncScreenRefresh,
            disabled=disabled,
        )
        self.type = "SlipscalePlate"
        self.exp.requireImport(
            importName="PlateOutput",
            importFrom="slipscale.experiments.psychopy_builder.plate_output",
        )
        self.order += ["amplitude_um_pp"]
        self.params["amplitude_um_pp"] = Param(
            amplitude_um_pp,
            valType="num",
            inputType="single",
            categ="Basic",
            updates="constant",
            allowedUpdates=["constant", "set every repeat"],
            label="Amplitude [µm peak to peak, or the plate's unit]",
            hint=(
                "0 switches the plate off. A number, a variable of the conditions file or an "
                "expression, such as $amplitude; it is read at the start of each repeat"
            ),
        )

    def writeInitCode(self, buff: Any) -> None:  # noqa: N802
        """Write the code that creates the component's object."""
        code = "%(name)s = PlateOutput(device=%(deviceLabel)s)\n"
        buff.writeIndentedLines(code % getInitVals(self.params, "PsychoPy"))

    def writeRoutineStartCode(self, buff: Any) -> None:  # noqa: N802
        """Write the code that sets the amplitude at the start of each repeat.

        PsychoPy writes "None" for a value that is set every repeat, and keeps the dollar sign of a
        constant.
        """
        value = str(self.params["amplitude_um_pp"].val).strip().removeprefix("$") or "None"
        buff.writeIndentedLines(f"{self.params['name']}.amplitude_um_pp = {value}\n")

    def writeFrameCode(self, buff: Any) -> None:  # noqa: N802
        """Write the code that starts the plate, checks it in every frame and stops it."""
        names = {**self.params, "loop": self.currentLoop}
        for write_test, code in (
            (self.writeStartTestCode, START),
            (self.writeActiveTestCode, CHECK),
            (self.writeStopTestCode, STOP),
        ):
            indented = write_test(buff)
            if indented:
                buff.writeIndentedLines(code % names)
                buff.setIndentLevel(-indented, relative=True)

    def writeRoutineEndCode(self, buff: Any) -> None:  # noqa: N802
        """Write the code that always stops the plate at the end of the routine."""
        buff.writeIndentedLines(STOP % self.params)
        super().writeRoutineEndCode(buff)


class SlipscalePlateBackend(DeviceBackend):  # type: ignore[misc] # PsychoPy has no types
    """Plate settings for the device manager's dialog."""

    backendLabel = "Slipscale plate"  # noqa: N815
    deviceClass = "slipscale.experiments.psychopy_plate.SlipscalePlate"  # noqa: N815
    icon = "light/plate.png"
    plugin = "slipscale"

    def getParams(self) -> tuple[dict[str, Any], list[str]]:  # noqa: N802
        """Return the only parameter that the dialog adds to PsychoPy's parameters: the SPEC."""
        spec = Param(
            "",
            valType="str",
            inputType="single",
            categ="Device",
            label="SPEC",
            hint="If empty, the selected device is used. Otherwise, enter the same value as for "
            "slipscale run --plate, such as scpi:RESOURCE,gain=20 or a plate file",
        )
        return {"spec": spec}, ["spec"]

    def writeDeviceCode(self, buff: Any) -> None:  # noqa: N802
        """Write the code that opens the plate when the experiment starts."""
        inits = getInitVals(self.params)
        spec = self.params["spec"].val or self.profile["spec"]
        buff.writeIndentedLines(
            f"deviceManager.addDevice(\n"
            f"    deviceName={inits['name']},\n"
            f"    deviceClass={self.deviceClass!r},\n"
            f"    spec={spec!r},\n"
            f")\n"
        )


SlipscalePlateComponent.registerBackend(SlipscalePlateBackend)
