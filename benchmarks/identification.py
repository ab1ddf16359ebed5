"""Ring-downs with noise: errors of identified frequency and damping, and how often intervals hold.

    python benchmarks/identification.py --records 100

simulates the free decay of a joint of 200 friction elements and two modes whose damping grows from
0.4 to 2.2 %, adds noise of one per cent of the largest value, and compares what each method
identifies with the backbone of the joint.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/measurement"))
from ring_downs import BAND, errors, ring_down, with_noise

from boltjoint import identify_ring_down

ELEMENTS = 200


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--records", type=int, default=100)
    records = parser.parse_args().records
    signals = ring_down(ELEMENTS, 3.0)
    print("method            noise  records  frequency  damping  intervals that hold")
    for method in ("analytic signal", "peak finding"):
        for noise, count in ((0.0, 1), (0.01, records)):
            found = []
            for seed in range(count):
                noisy = with_noise(signals, noise, seed)
                mode = identify_ring_down(noisy, BAND, method=method)
                found.append(errors(mode, ELEMENTS))
            f, z, *ratios = (np.concatenate(each) for each in zip(*found, strict=True))
            held = " ".join(f"{np.mean(abs(ratio) < 1.96):8.1%}" for ratio in ratios)
            print(
                f"{method:16s} {noise:6.2%} {count:8d} {np.median(abs(f)):10.4%} "
                f"{np.median(abs(z)):8.2%} {held if noise else ''}"
            )


if __name__ == "__main__":
    main()
