"""Ranges do not depend on threads; errors and Ctrl-C stop the work and leave nothing running."""

import os
import signal
import threading
import time

import pytest

from photonmap.runtime.workers import Workers


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_ranges(threads):
    with Workers(threads) as workers:
        assert workers.threads == threads
        spans = workers.ranges(lambda first, last: (first, last), 10, 4)
        assert spans == [(0, 4), (4, 8), (8, 10)]
        assert workers.ranges(lambda first, last: 1, 0, 4) == []


def test_an_error_is_raised_and_the_rest_dropped():
    ran = []

    def task(index):
        if index == 0:
            raise RuntimeError("kernel failed")
        time.sleep(0.01)
        ran.append(index)

    with Workers(1) as workers, pytest.raises(RuntimeError, match="kernel failed"):
        workers.map(task, 50)
    assert len(ran) < 49


def test_ctrl_c_is_held_until_a_call_that_may_stop():
    with Workers(2) as workers, workers.holding_interrupts():
        os.kill(os.getpid(), signal.SIGINT)
        assert workers.map(lambda index: index, 3, uninterrupted=True) == [0, 1, 2]
        with pytest.raises(KeyboardInterrupt):
            workers.map(lambda index: index, 3)
        assert threading.current_thread() is threading.main_thread()


def test_a_second_ctrl_c_is_not_held():
    with Workers(1) as workers, workers.holding_interrupts():
        os.kill(os.getpid(), signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)


def test_outside_the_main_thread_work_goes_on():
    result = []

    def work():
        with Workers(1) as workers, workers.holding_interrupts():
            result.extend(workers.map(lambda index: index, 2))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert result == [0, 1]
