"""gearfem: stiffness and dynamics of spur gears, worn ones above all."""
