"""The first signal ends a training cleanly, the second at once, and the same one twice is one."""

import signal
import threading
import time

import pytest

from lift_lab_rl import stop_signals
from lift_lab_rl.distributed import Place
from lift_lab_rl.stop_signals import StopSignals

ALONE, MAIN, OTHER = Place(), Place(world_size=2), Place(rank=1, world_size=2)


def send(number=signal.SIGTERM):
    signal.raise_signal(number)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_first_signal_is_said_and_agreed_on_and_the_handlers_before_come_back(number):
    before, said, signals = signal.getsignal(number), [], StopSignals(ALONE)
    with signals.caught(said.append):
        assert not signals.agree()
        send(number)
        assert signals.agree()
    assert said == [f"{number.name}: finishing this iteration, then saving (again to end at once)"]
    assert signal.getsignal(number) is before


def test_a_second_signal_ends_at_once():
    signals = StopSignals(ALONE)
    with signals.caught(lambda _: None):
        send()
        with pytest.raises(KeyboardInterrupt):
            send(signal.SIGINT)


def test_with_several_processes_the_second_counts_after_a_while_only(monkeypatch):
    signals = StopSignals(MAIN)
    with signals.caught(lambda _: None):
        send()
        send()
        later = time.monotonic() + stop_signals.REPEATED_S + 0.1
        monkeypatch.setattr(stop_signals.time, "monotonic", lambda: later)
        with pytest.raises(KeyboardInterrupt):
            send()
    assert signals.agree()


def test_a_process_that_learns_of_anothers_signal_takes_its_own_for_the_same(monkeypatch):
    monkeypatch.setattr(stop_signals.distributed, "stop_number", lambda own: int(signal.SIGINT))
    signals = StopSignals(OTHER)
    with signals.caught():
        assert signals.agree()
        send()


def test_only_the_main_process_speaks(capsys):
    for place in (OTHER, MAIN):
        with StopSignals(place).caught():
            send()
    assert capsys.readouterr().err.count("SIGTERM: finishing") == 1


def test_another_thread_catches_nothing():
    before, during = signal.getsignal(signal.SIGTERM), []

    def look():
        with StopSignals(ALONE).caught():
            during.append(signal.getsignal(signal.SIGTERM))

    thread = threading.Thread(target=look)
    thread.start()
    thread.join()
    assert during == [before]
