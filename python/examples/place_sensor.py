"""Places a sensor by a loop of one's own: along the shaft of a pointer, where the tip is off least.

    python place_sensor.py
"""

from __future__ import annotations

import numpy as np

import trackwright

# Where the sensor is tried: along the shaft, mm.
STEPS_MM = np.linspace(0.0, 40.0, 9)


def main() -> tuple[trackwright.Design, float]:
    design = trackwright.Design.builtin("pointer-on-head")
    # A coarser range of motion than the design's own: the loop visits it many times.
    design = design.with_motion({"x": (-40, 40, 40), "y": (-40, 40, 40), "rz": (-60, 60, 60)})
    sensor = next(sensor for sensor in design.sensors() if sensor.name == "grip")
    # The axis of the pointer's shaft is its body's z.
    along = np.array([0.0, 0.0, 1.0])

    tried: list[tuple[float, float, trackwright.Design]] = []
    for step_mm in STEPS_MM:
        moved = design.with_sensor("grip", sensor.position + step_mm * along)
        found = trackwright.simulate(moved, "motion", expected=False)
        rms_mm = found.figures["room_field"]["position_mm"]["rms"]
        print(f"{step_mm:5.1f} mm along the shaft: tip error {rms_mm:.4f} mm RMS "
              f"over {found.figures['trials']} poses")
        tried.append((rms_mm, step_mm, moved))
    rms_mm, step_mm, best = min(tried, key=lambda each: each[0])
    print(f"best: {step_mm:.1f} mm, {rms_mm:.4f} mm RMS")

    # Those are errors by the room's model alone. The one design that is kept gets the figure that is to
    # be expected, and its interval.
    whole = trackwright.simulate(best, "motion").figures
    rms = whole["figures"]["position_mm"]["rms"]
    print(f"expected {rms['value']:.3f} mm RMS (95 %: {rms['low']:.3f} to {rms['high']:.3f} mm)")
    return best, rms_mm


if __name__ == "__main__":
    main()
