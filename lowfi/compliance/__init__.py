"""Body compliance between contact points: what a force on one flank does to every other, through screw, nut and ball."""
