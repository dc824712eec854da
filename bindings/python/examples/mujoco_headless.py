"""A door on a hinge, a box on a floor, and one finger that pushes both, in MuJoCo without a window.

    pip install palpate[mujoco]
    python mujoco_headless.py

palpate renders the contacts of the finger; MuJoCo simulates hinge and floor. At the end the program prints the motion
of door and box, the impulse of the device, and the energy that the held force generated beyond the contacts' work.
"""

from __future__ import annotations

import mujoco
import numpy as np

from palpate.engines import SimulatedDevice
from palpate.engines.mujoco import Contact

MODEL = """
<mujoco>
  <option timestep="0.001" integrator="implicitfast"/>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 0.1"/>
    <body name="door" pos="0 0.2 0.1">
      <joint name="hinge" type="hinge" axis="0 0 1" damping="0.001"/>
      <geom type="box" pos="0.1 0 0" size="0.1 0.005 0.08" mass="0.2"/>
    </body>
    <body name="box" pos="0.15 0.1 0.03">
      <freejoint/>
      <geom type="box" size="0.03 0.03 0.03" mass="0.1" friction="0.3"/>
    </body>
  </worldbody>
</mujoco>
"""


def main(seconds: float = 1.5) -> dict[str, float]:
    """Pushes for `seconds` [s] and returns the results."""
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    period = 0.002
    contact = Contact(
        model, data, tool=0.01, bodies=["door", "box"], stiffness=2000.0, friction=0.3, device_mass=0.2, period=period
    )
    # A hand that moves along y and pushes the box against the door.
    device = SimulatedDevice([0.2] * 3, [0.15, 0.05, 0.03], 200.0, 4.0, [0.15, 0.05, 0.03], [0, 0, 0], period)
    given = 0.0
    for tick in range(round(seconds / period)):
        device.rest[1] = 0.05 + 0.12 * min(1.0, tick * period / seconds)
        force = contact.step(device.position)
        given -= period * force[1]
        device.hold(force)
    ledger, _ = contact.ledger
    return {
        "angle of the door [rad]": float(data.joint("hinge").qpos[0]),
        "displacement of the box along y [m]": float(data.body("box").xpos[1] - 0.1),
        "impulse of the device along y [N s]": given,
        "energy beyond the contacts' work [J]": sum(entry.leak for entry in ledger),
        "largest force now [N]": float(np.abs(force).max()),
    }


if __name__ == "__main__":
    for what, number in main().items():
        print(f"{what:45} {number:.4g}")
