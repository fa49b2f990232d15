"""Double supports, postures and quasi-static whole-body motions (paper, section IV)."""
