"""What a screening found, and the samples that it cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.samples.stretches import Stretch
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding


@dataclass(frozen=True)
class LeftOut:
    """Samples of one run that do not count, for one fault.

    Attributes:
        run: its number.
        fault: why.
        samples: how many; each counts for the first fault that was found of it.
        share: of the run's samples.
        stretches: first and last time of each stretch of them, since the run's start [s].
        channels: names of the faulty ones; empty where all are concerned.
    """

    run: int
    fault: Fault
    samples: int
    share: float
    stretches: tuple[Stretch, ...] = ()
    channels: tuple[str, ...] = ()

    def to_json(self) -> dict[str, object]:
        """The same by name."""
        return {
            "run": self.run,
            "fault": self.fault.value,
            "samples": self.samples,
            "share": self.share,
            "stretches_s": [list(stretch) for stretch in self.stretches],
            "channels": list(self.channels),
        }


@dataclass(frozen=True)
class Screening:
    """What was found in a recording before the fit.

    Attributes:
        findings: for the verdict.
        left_out: samples that do not count, by run and fault.
        samples: of each run, as recorded.
        kept: (T,) of each run's aligned samples, where it was screened: those that count.
        standing: (T,) of them: those at which both feet stand where they stood at first.
        air: (T,) of them, in runs that lift a foot: those at which it hangs free, as heights and
            load agree.
        hanging: (T,) of them, in runs in double support in which the whole robot is lifted for a
            while: those at which both feet hang still.
        load: (T, 2) of them, in double support: each foot's share of the weight, by gains and
            offsets that are roughly known by then.
        time_offset: joints were late by this much against the readings, and are so no more [s].
    """

    findings: tuple[Finding, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    samples: Mapping[int, int] = field(default_factory=dict)
    kept: Mapping[int, BoolArray] = field(default_factory=dict)
    standing: Mapping[int, BoolArray] = field(default_factory=dict)
    air: Mapping[int, BoolArray] = field(default_factory=dict)
    hanging: Mapping[int, BoolArray] = field(default_factory=dict)
    load: Mapping[int, FloatArray] = field(default_factory=dict)
    time_offset: float = 0.0

    @property
    def runs_left_out(self) -> tuple[int, ...]:
        """Runs of which nothing counts."""
        return tuple(run for run, kept in self.kept.items() if not kept.any())

    @property
    def fails(self) -> bool:
        """Something spoils the whole session."""
        return any(finding.verdict == "FAIL" for finding in self.findings)

    def adding(self, findings: Sequence[Finding]) -> Screening:
        """The same with more findings."""
        return replace(self, findings=(*self.findings, *findings))

    def to_json(self) -> dict[str, object]:
        """Figures by their names in result files."""
        return {
            "samples": {str(run): count for run, count in self.samples.items()},
            "left_out": [one.to_json() for one in self.left_out],
            "runs_left_out": list(self.runs_left_out),
            "time_offset_s": self.time_offset,
            "findings": [
                {
                    "verdict": one.verdict,
                    "fault": one.fault.value if one.fault else "",
                    "reason": one.reason,
                }
                for one in self.findings
            ],
        }
