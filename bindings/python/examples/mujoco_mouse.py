"""MuJoCo's window with a simulated device, which the mouse holds like a hand.

    pip install palpate[mujoco]
    python mujoco_mouse.py              # on macOS: mjpython mujoco_mouse.py

Double-click the yellow ball, which is the tool, then drag it with Ctrl and the right mouse button: a spring pulls the
device to the mouse position. palpate renders the contacts of the tool at 500 Hz; MuJoCo simulates everything else. The
window shows the force on the device.
"""

from __future__ import annotations

import time
from typing import Any

import mujoco
import numpy as np

from palpate.engines import SimulatedDevice
from palpate.engines.mujoco import Contact

MODEL = """
<mujoco>
  <option timestep="0.001" integrator="implicitfast"/>
  <visual><global azimuth="90" elevation="-25"/></visual>
  <worldbody>
    <light pos="0 -0.5 1.5" dir="0 0.3 -1"/>
    <geom name="floor" type="plane" size="0.5 0.5 0.1" rgba="0.8 0.8 0.8 1"/>
    <body name="hand" mocap="true" pos="0 -0.1 0.06">
      <geom name="tool" type="sphere" size="0.012" rgba="0.95 0.75 0.1 1"/>
    </body>
    <body name="ball" pos="-0.06 0 0.03"><freejoint/><geom type="sphere" size="0.03" mass="0.1" rgba="0.2 0.5 0.9 1"/></body>
    <body name="box" pos="0.06 0 0.03"><freejoint/><geom type="box" size="0.03 0.03 0.03" mass="0.1" rgba="0.9 0.3 0.2 1"/></body>
  </worldbody>
</mujoco>
"""
PERIOD = 0.002


def set_up() -> tuple[mujoco.MjModel, mujoco.MjData, Contact, SimulatedDevice]:
    """Creates the scene, its contacts, and the device in the hand."""
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    contact = Contact(
        model,
        data,
        tool="tool",
        bodies=["ball", "box", "world"],
        stiffness=1000.0,
        friction=0.5,
        damping=1.0,
        device_mass=0.2,
        period=PERIOD,
    )
    start = data.mocap_pos[0].copy()
    return model, data, contact, SimulatedDevice([0.2] * 3, start, 100.0, 4.0, start, [0, 0, 0], PERIOD)


def drive(viewer: Any, model: mujoco.MjModel, data: mujoco.MjData, contact: Contact, device: SimulatedDevice) -> None:
    """Moves the device with the mouse in real time until the window is closed."""
    hand = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "hand")
    frame, due = 1 / 60, time.perf_counter()
    while viewer.is_running():
        with viewer.lock():
            grabbed = viewer.perturb.select == hand and viewer.perturb.active
            if grabbed:
                device.rest[:] = viewer.perturb.refpos
            for _ in range(round(frame / PERIOD)):
                force = contact.step(device.position)
                device.hold(force)
            viewer.set_texts((None, None, "force on the device", f"{np.linalg.norm(force):5.2f} N"))
        viewer.sync()
        due += frame
        wait = due - time.perf_counter()
        if wait > 0:
            time.sleep(wait)
        else:
            # Late: the lost time is not made up.
            due -= wait


def main() -> None:
    """Opens the window."""
    import mujoco.viewer

    model, data, contact, device = set_up()
    with mujoco.viewer.launch_passive(model, data) as viewer:
        drive(viewer, model, data, contact, device)


if __name__ == "__main__":
    main()
