"""The Power Crust (Amenta, Choi, Kolluri 2001)."""
