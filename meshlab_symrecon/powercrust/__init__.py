"""The Power Crust (Amenta, Choi, Kolluri 2001)."""

from meshlab_symrecon.powercrust.recipe import Recipe
from meshlab_symrecon.powercrust.reconstruction import PowerCrust, reconstruct

__all__ = ["PowerCrust", "Recipe", "reconstruct"]
