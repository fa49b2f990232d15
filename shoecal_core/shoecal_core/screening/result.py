"""What a screening found, and the samples that it cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.samples.stretches import Stretch, list_stretches
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding

NOTABLE: Mapping[Fault, float] = {
    Fault.UNREADABLE: 0.2,
    Fault.TOO_FAST: 0.02,
    Fault.DISTURBED: 0.2,
    Fault.LIFTED: 0.0,
}
"""Share of a run's samples from which their loss is a warning; less is only counted."""
NOTABLE_SPIKES = 3
"""Samples with spikes in one channel and run from which its cable is suspected."""
_CURES: Mapping[Fault, tuple[str, str]] = {
    Fault.UNREADABLE: (
        "has no readings, bad or repeated ones, or no joint angles at the same time",
        "check the device's status and rate of sampling, and that both have stamps of one clock",
    ),
    Fault.TOO_FAST: ("moved too fast to be taken as standing still", "plan a slower motion"),
    Fault.DISTURBED: (
        "was disturbed",
        "see that nothing touches the robot, and that its gears and floor are firm",
    ),
    Fault.LIFTED: (
        "had its {foot} foot in the air or on its edge",
        "see that it is not lifted and that the motion keeps load on both feet",
    ),
}


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
        foot: the one that was lifted, by its load; empty for other faults.
    """

    run: int
    fault: Fault
    samples: int
    share: float
    stretches: tuple[Stretch, ...] = ()
    channels: tuple[str, ...] = ()
    foot: str = ""

    def to_json(self) -> dict[str, object]:
        """The same by name."""
        return {
            "run": self.run,
            "fault": self.fault.value,
            "samples": self.samples,
            "share": self.share,
            "stretches_s": [list(stretch) for stretch in self.stretches],
            "channels": list(self.channels),
            "foot": self.foot,
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


def describe_left_out(found: Sequence[LeftOut]) -> list[Finding]:
    """Samples left out, where they are more than a good recording has."""
    findings = []
    for one in found:
        times = list_stretches(one.stretches)
        if one.fault is Fault.SPIKE and one.samples >= NOTABLE_SPIKES:
            findings.append(
                Finding(
                    "WARN",
                    f"{', '.join(one.channels)} gave spikes in run {one.run} ({times}), left "
                    "out: check the cable and its shield",
                    one.fault,
                )
            )
        elif one.share > NOTABLE.get(one.fault, 1.0):
            happened, cure = (part.format(foot=one.foot) for part in _CURES[one.fault])
            findings.append(
                Finding(
                    "WARN",
                    f"run {one.run} {happened} for {one.share:.0%} of its samples"
                    f"{f' ({times})' if times else ''}, left out: {cure}",
                    one.fault,
                )
            )
        elif one.fault is Fault.TOO_LITTLE:
            findings.append(
                Finding(
                    "WARN",
                    f"run {one.run} is left out: too little of it can be used; record it again",
                    one.fault,
                )
            )
    return findings
