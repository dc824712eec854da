"""A device of one's own: here a mass of 0.2 kg that a hand moves to and fro. Replace its motion by your hardware."""
import math, sys, time

force, x, v, before = 0.0, -0.01, 0.0, time.monotonic()  # [N], [m], [m/s], [s]
for line in sys.stdin:
    word, *values = line.split() or [""]
    if word == "hello":
        print("device 1 axes=1 largest_force_n=5 mass_kg=0.2 name=my device", flush=True)
    elif word == "read":
        now = time.monotonic()
        hand = 0.02 * math.sin(4.0 * now)  # the hand holds the device by a spring and a damper
        v += (force + 200.0 * (hand - x) - 10.0 * v) / 0.2 * min(now - before, 0.01)
        x, before = x + v * min(now - before, 0.01), now
        print("sample", values[0], values[0], now, x, flush=True)
    elif word in ("wrench", "zero"):
        force = float(values[1]) if word == "wrench" else 0.0
