"""What the native side writes to the standard streams is told apart from what Python writes."""

from __future__ import annotations

import os
import sys

import click
import pytest

from meshlab_symrecon.host.files import new_document
from meshlab_symrecon.host.native_log import native_log


def test_python_goes_through_and_the_native_side_is_dropped(capfd):
    with native_log(new_document()):
        click.echo("python")
        click.echo("warning", err=True)
        os.write(1, b"native\n")
        os.write(2, b"native\n")
    os.write(1, b"after\n")
    click.echo("end")
    assert capfd.readouterr() == ("python\nafter\nend\n", "warning\n")


def test_lines_are_taken_once_in_order_without_mark_and_progress(capfd):
    mesh_set = new_document()
    said = []
    with native_log(mesh_set) as log:
        os.write(2, b"LOG: 2 before\n")
        with log.listening(said.append) as relay:
            os.write(2, b"LOG: 2 Mesh Volume  is 4.0  \nchatter\nLOG: 2     | 1.0 |\n\n")
            click.echo("parameters")
            relay(0.5, "step")
            assert said == ["Mesh Volume  is 4.0", "    | 1.0 |"]
            os.write(2, b"LOG: 2 create_cube applied!    [ 100% ]\nLOG: 1 gr\xc3\xb6\xc3\x9fe\n")
        assert said[2:] == ["größe"]
        assert log.take() == []
    assert capfd.readouterr() == ("", "")


def test_what_is_said_while_listening_goes_to_the_output(capfd):
    with native_log(new_document()) as log, log.listening(click.echo):
        os.write(2, b"LOG: 2 one\n")
        click.echo("hidden")
    assert capfd.readouterr().out == "one\n"


def failing():
    with native_log(new_document()) as log, log.listening(click.echo):
        os.write(2, b"LOG: 2 said\n")
        raise ValueError("inside")


def test_streams_come_back_after_an_error(capfd):
    streams = sys.stdout, sys.stderr
    with pytest.raises(ValueError, match="inside"):
        failing()
    assert (sys.stdout, sys.stderr) == streams
    os.write(1, b"out\n")
    os.write(2, b"err\n")
    assert capfd.readouterr() == ("said\nout\n", "err\n")


def test_streams_that_are_no_files_stay_as_they_are(capsys):
    with native_log(new_document()):
        click.echo("kept")
        os.write(1, b"dropped\n")
    assert capsys.readouterr().out == "kept\n"
