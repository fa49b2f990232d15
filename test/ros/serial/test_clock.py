from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from itertools import groupby

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_ros.serial.clock import DeviceClock

EPOCH = 1_780_000_000_123_456_789
MS = 1_000_000
Delay = Callable[[random.Random], float]


def jitter(rng: random.Random) -> float:
    """Scheduler and cable: 0.3 ms on average, one frame in a hundred up to 100 ms."""
    stall = rng.uniform(0, 100) if rng.random() < 0.01 else 0.0
    return rng.expovariate(1 / 0.3) + stall


def received(
    rate: float, seconds: float, *, skew: float, delay: Delay, batch_ms: int = 0, seed: int = 1
) -> Iterator[tuple[int, list[tuple[int, int]]]]:
    """Receipts [ns], each with the device times [us] and true host times [ns] of its frames."""
    rng = random.Random(seed)
    last = 0
    arrivals = []
    for k in range(int(rate * seconds)):
        device_us = round(k * 1e6 / rate)
        true = EPOCH + round(device_us * 1000 * (1 + skew))
        last = max(last, true + int(delay(rng) * MS))
        arrivals.append((device_us, true, last))
    step = batch_ms * MS or 1
    for receipt, group in groupby(arrivals, key=lambda arrival: -(-arrival[2] // step) * step):
        yield receipt, [(device_us, true) for device_us, true, _ in group]


def errors_ms(
    clock: DeviceClock, stream: Iterator[tuple[int, list[tuple[int, int]]]]
) -> list[float]:
    """Stamp minus true time of every frame [ms], checked to grow strictly."""
    errors = []
    last = 0
    for receipt, group in stream:
        stamps = clock.stamps([device_us for device_us, _ in group], receipt)
        for stamp, (_, true) in zip(stamps, group, strict=True):
            assert stamp > last
            last = stamp
            errors.append((stamp - true) / MS)
    return errors


@pytest.mark.parametrize("rate", [10.0, 80.0, 100.0, 1000.0])
@pytest.mark.parametrize("skew", [0.0, 1e-4, -1e-4, 5e-3])
def test_jitter_and_skew_leave_errors_under_a_tenth_of_a_millisecond(
    rate: float, skew: float
) -> None:
    clock = DeviceClock()
    errors = errors_ms(clock, received(rate, 40, skew=skew, delay=jitter))
    steady = errors[int(3 * rate) :]
    assert max(map(abs, steady)) < 0.1
    assert clock.drift == pytest.approx(skew, abs=5e-6)
    assert clock.resets == 0


@pytest.mark.parametrize(
    ("rate", "bound_ms"), [(10.0, 6.0), (80.0, 1.5), (100.0, 2.5), (1000.0, 1.5)]
)
@pytest.mark.parametrize("skew", [1e-4, -1e-4])
def test_batches_of_16_ms(rate: float, bound_ms: float, skew: float) -> None:
    clock = DeviceClock()
    stream = received(rate, 60, skew=skew, delay=lambda rng: rng.expovariate(3), batch_ms=16)
    errors = errors_ms(clock, stream)
    steady = errors[int(3 * rate) :]
    assert max(map(abs, steady)) < bound_ms
    assert sum(map(abs, steady)) / len(steady) < bound_ms / 2
    assert clock.resets == 0


def test_first_seconds_are_off_by_no_more_than_the_drift_makes() -> None:
    errors = errors_ms(DeviceClock(), received(100, 3, skew=-5e-3, delay=jitter))
    assert max(errors[100:]) < 0.5
    assert min(errors) > -0.5
    errors = errors_ms(DeviceClock(), received(100, 3, skew=5e-3, delay=jitter))
    assert min(errors) > -11


def test_frames_that_waited_are_stamped_by_the_last_of_them() -> None:
    clock = DeviceClock()
    backlog = list(range(0, 3_000_000, 10_000))
    receipt = EPOCH + backlog[-1] * 1000 + MS
    stamps = clock.stamps(backlog, receipt)
    assert stamps == [EPOCH + device_us * 1000 + MS for device_us in backlog]


def simulated(
    seconds: float, *, offset_ns: int, speed: float, rate: float = 100.0, tick_ms: int = 10
) -> Iterator[tuple[int, list[tuple[int, int]]]]:
    """A simulation `speed` times as fast as real time; delays are real, 1 ms on average.

    The host's clock shows the last tick that has arrived; one frame in fifty meets a stall.
    """
    rng = random.Random(3)
    last_frame = last_tick = 0.0
    for k in range(int(rate * seconds)):
        device_us = round(k * 1e6 / rate) + 1_000_000
        true = device_us * 1000 + offset_ns
        stall = rng.uniform(0, 30) if rng.random() < 0.02 else 0.0
        last_frame = max(last_frame, true + speed * MS * (rng.expovariate(1) + stall))
        shown = last_frame - speed * MS * rng.expovariate(1)
        last_tick = max(last_tick, shown // (tick_ms * MS) * tick_ms * MS)
        yield int(last_tick), [(device_us, true)]


@pytest.mark.parametrize("speed", [1.0, 10.0, 30.0])
def test_simulated_time_that_the_device_counts_is_exact(speed: float) -> None:
    clock = DeviceClock()
    errors = errors_ms(clock, simulated(60, offset_ns=0, speed=speed))
    assert set(errors) == {0.0}
    assert clock.same_clock
    assert clock.resets == 0


def test_late_beginning_of_simulated_time_is_corrected_at_once() -> None:
    clock = DeviceClock()
    (late,) = clock.stamps([1_000_000], 1_900 * MS)
    assert late == 1_900 * MS
    assert clock.stamps([1_010_000, 1_020_000], 1_100 * MS) == [1_010 * MS, 1_020 * MS]
    assert clock.resets == 1


def test_simulated_time_that_the_device_does_not_count() -> None:
    clock = DeviceClock()
    errors = errors_ms(clock, simulated(60, offset_ns=77_123_456_000, speed=1.0))
    steady = errors[300:]
    # Early by the steps and the lateness of the host's clock, of which nobody can know.
    assert min(steady) > -30
    assert max(steady) < 10
    assert not clock.same_clock


def test_a_device_set_by_the_hosts_real_clock_is_followed_not_believed() -> None:
    """It may be off by some ms, and a clock that ticks finely can tell."""
    clock = DeviceClock()
    rng = random.Random(4)
    errors = []
    for k in range(2000):
        true = EPOCH + k * 10 * MS
        device_us = (true + 30 * MS) // 1000
        (stamp,) = clock.stamps([device_us], true + int(jitter(rng) * MS))
        errors.append((stamp - true) / MS)
    assert not clock.same_clock
    assert max(map(abs, errors[300:])) < 0.1


def follow(clock: DeviceClock, device_us: range, offset_ns: int) -> list[int]:
    """Errors [ns] of a stretch of frames received without delay."""
    return [
        clock.stamps([us], us * 1000 + offset_ns)[0] - us * 1000 - offset_ns for us in device_us
    ]


def test_device_restart() -> None:
    clock = DeviceClock()
    follow(clock, range(50_000_000, 60_000_000, 10_000), EPOCH)
    errors = follow(clock, range(0, 10_000_000, 10_000), EPOCH + 63_000 * MS)
    assert clock.resets == 1
    assert max(map(abs, errors)) <= 1


def test_device_restart_among_frames_received_together() -> None:
    clock = DeviceClock()
    clock.stamps([50_000_000], EPOCH)
    stamps = clock.stamps([50_010_000, 100_000, 110_000], EPOCH + 200 * MS)
    assert stamps == [EPOCH + 10 * MS, EPOCH + 190 * MS, EPOCH + 200 * MS]
    assert clock.resets == 1


@pytest.mark.parametrize("first", [True, False])
@pytest.mark.parametrize("jump_us", [60_000_000, 2**63])
def test_device_clock_that_jumps_ahead_among_frames_received_together(
    first: bool, jump_us: int
) -> None:
    """Frames before the jump are as old as their receipt tells, not as the jump is long."""
    clock = DeviceClock()
    if not first:
        assert clock.stamps([980_000], EPOCH) == [EPOCH]
    stamps = clock.stamps([990_000, 1_000_000, 1_000_000 + jump_us], EPOCH + 20 * MS)
    assert EPOCH < stamps[0] < stamps[1] < stamps[2] <= EPOCH + 20 * MS + 1


@pytest.mark.parametrize("seconds", [-3600.0, -0.2, 0.13, 0.7, 3600.0])
def test_host_clock_that_is_set(seconds: float) -> None:
    clock = DeviceClock()
    follow(clock, range(0, 10_000_000, 10_000), EPOCH)
    errors = follow(clock, range(10_000_000, 20_000_000, 10_000), EPOCH + round(seconds * 1e9))
    assert clock.resets == 1
    # A little forward it could as well be a stall, so a second goes by; else there is no doubt.
    settled = errors[110:] if 0.0 < seconds < 10.0 else errors
    assert max(map(abs, settled)) <= 1


@pytest.mark.parametrize("back_us", [1, 999])
def test_a_device_clock_that_is_read_unevenly_is_not_begun_anew(back_us: int) -> None:
    clock = DeviceClock()
    last = 0
    for index in range(1000):
        device_us = index * 10_000 - (10_000 + back_us) * (index % 50 == 49)
        for stamp in clock.stamps([device_us], EPOCH + index * 10 * MS):
            assert stamp > last
            last = stamp
    assert clock.resets == 0
    assert abs(last - (EPOCH + 999 * 10 * MS)) < 20 * MS


@pytest.mark.parametrize("back_ms", [81, 100, 128])
def test_a_host_clock_that_is_set_back_a_little_is_followed_at_once(back_ms: int) -> None:
    clock = DeviceClock()
    for index in range(2000):
        receipt = EPOCH + (index * 10 - (back_ms if index >= 1000 else 0)) * MS
        (stamp,) = clock.stamps([index * 10_000], receipt)
        if not 1000 <= index < 1000 + back_ms:
            assert abs(stamp - receipt) < MS
    assert clock.resets == 1


@pytest.mark.parametrize("seconds", [1, 30])
def test_a_host_clock_that_stands_leads_stamps_astray_by_little_and_not_for_long(
    seconds: int,
) -> None:
    clock, rng = DeviceClock(), random.Random(5)
    host = EPOCH
    for index in range(100 * (20 + seconds + 5)):
        stands = 2000 <= index < 2000 + 100 * seconds
        host += 0 if stands else 10 * MS
        (stamp,) = clock.stamps([index * 10_000], host + int(rng.expovariate(2.5) * MS))
        assert abs(stamp - host) < (100 if stands or index < 2020 + 100 * seconds else 20) * MS


def test_simulation_that_starts_over() -> None:
    clock = DeviceClock()
    for _ in range(2):
        for tick in range(1, 500):
            assert clock.stamps([tick * 10_000], tick * 10 * MS) == [tick * 10 * MS]
    assert clock.resets == 1


def test_stall_of_the_host_is_no_jump() -> None:
    clock = DeviceClock()
    follow(clock, range(0, 10_000_000, 10_000), EPOCH)
    for us in range(10_000_000, 10_900_000, 10_000):
        clock.stamps([us], EPOCH + 10_950 * MS)
    errors = follow(clock, range(11_000_000, 20_000_000, 10_000), EPOCH)
    assert clock.resets == 0
    assert max(map(abs, errors)) <= 1


def test_pause_longer_than_the_window_keeps_the_drift() -> None:
    clock = DeviceClock()
    for us in [*range(0, 10_000_000, 10_000), *range(60_000_000, 70_000_000, 10_000)]:
        true = EPOCH + us * 1000 + us // 10
        (stamp,) = clock.stamps([us], true)
        if us > 3_000_000:
            assert abs(stamp - true) < 1000
    assert clock.resets == 0


@given(
    st.lists(
        st.tuples(st.integers(0, 2**64 - 1), st.integers(-(2**62), 2**62)), min_size=1, max_size=40
    )
)
def test_any_times_give_stamps(times: list[tuple[int, int]]) -> None:
    clock = DeviceClock()
    for device_us, receipt in times:
        assert len(clock.stamps([device_us], receipt)) == 1
