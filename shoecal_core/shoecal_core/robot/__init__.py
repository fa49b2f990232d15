"""From joint angles to centre of mass (CoM), sole poses and modelled CoP."""
