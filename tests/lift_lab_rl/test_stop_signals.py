"""The first signal ends a training cleanly, the second at once, and the same one twice is one."""

import signal
import threading
import time

import pytest

from lift_lab.app.output import Output
from lift_lab_rl import stop_signals
from lift_lab_rl.distributed import Place
from lift_lab_rl.stop_signals import StopSignals

ALONE, MAIN, OTHER = Place(), Place(world_size=2), Place(rank=1, world_size=2)


def send(number=signal.SIGTERM):
    signal.raise_signal(number)


def hang_up():
    send(signal.SIGHUP)


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


def test_a_lost_terminal_ends_a_training_however_often_it_says_so(capsys):
    signals = StopSignals(ALONE)
    with signals.caught(pytest.fail):
        hang_up()
        hang_up()
        assert signals.agree() == signal.SIGHUP
    assert capsys.readouterr().err == "SIGHUP or lost output: finishing this iteration, then saving\n"


@pytest.mark.parametrize("order", [(signal.SIGHUP, signal.SIGTERM), (signal.SIGTERM, signal.SIGHUP)])
def test_a_lost_terminal_and_one_more_signal_still_save(order):
    signals = StopSignals(ALONE)
    with signals.caught(lambda _: None):
        for number in order:
            send(number)
        assert signals.agree() == signal.SIGTERM
        with pytest.raises(KeyboardInterrupt):
            send(signal.SIGINT)


def test_nohup_is_respected():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signals = StopSignals(ALONE)
    try:
        with signals.caught():
            hang_up()
            assert signals.agree() is None
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


def test_output_that_is_lost_stands_for_sighup(monkeypatch):
    signals = StopSignals(ALONE)
    with signals.caught(), open("/dev/full", "w") as full:
        monkeypatch.setattr("sys.stdout", Output(full, "standard output"))
        print("a line", flush=True)
        assert signals.agree() == signal.SIGHUP


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
