from __future__ import annotations

import threading

from shoecal_ros.common.callback_lock import CallbackLock


def test_who_has_always_more_to_do_lets_others_in() -> None:
    turn, done = CallbackLock(), threading.Event()
    served = 0

    def be_quick() -> None:
        nonlocal served
        for _ in range(200):
            with turn:
                served += 1
        done.set()

    quick = threading.Thread(target=be_quick, daemon=True)
    quick.start()
    turns = 0
    while not done.is_set():
        with turn:
            sum(range(20_000))  # at work for longer than it is away
        turns += 1
    quick.join()
    assert served == 200
    assert turns < 400, "the other one came in at every turn"
