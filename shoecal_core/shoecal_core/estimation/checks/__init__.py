"""May a calibration be used: after a fit, of other programs, and live on a robot that stands?"""
