"""Make the pictures of the README and of the first pages: .venv/bin/python docs/pictures.py."""

from pathlib import Path

import legspring as ls
from legspring.figures import draw_animals, draw_atlas, draw_gait, save_figure

IMAGES = Path(__file__).parent / "images"


def main() -> None:
    """Draw each picture into its file."""
    roach = ls.cockroach()
    gait = ls.find_gaits(roach, slope_deg=45, heading=0.15)[0]
    ls.animate(gait, strides=1, width=360).save(IMAGES / "run.gif")
    save_figure(draw_gait(gait), IMAGES / "gait.png")
    save_figure(draw_animals([ls.load_animal(name) for name in ls.presets()]), IMAGES / "presets.png")
    save_figure(draw_atlas(ls.atlas(roach, impulses=()), "max_multiplier"), IMAGES / "eigenvalue.png")


if __name__ == "__main__":
    main()
