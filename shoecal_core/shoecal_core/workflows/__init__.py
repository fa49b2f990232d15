"""What commands and nodes both do, one module a job: calibrate, evaluate, diagnose, simulate."""
