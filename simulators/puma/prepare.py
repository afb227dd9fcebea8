"""Compile the loops over pictures, once after an installation: `python -m simulators.puma.prepare`."""

from simulators.puma.plant import Plant
from simulators.puma.render import RasterRenderer

if __name__ == "__main__":
    plant = Plant()
    RasterRenderer(plant.model, 64, 48).take(plant.data, "front")
