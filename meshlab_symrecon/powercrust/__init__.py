"""The Power Crust (Amenta, Choi, Kolluri 2001)."""

from meshlab_symrecon.powercrust.reconstruction import PowerCrust, Recipe, reconstruct

__all__ = ["PowerCrust", "Recipe", "reconstruct"]
