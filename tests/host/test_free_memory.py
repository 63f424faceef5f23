"""What a process may still use, on machines that are made of files."""

from __future__ import annotations

import resource
import subprocess
import sys

import pytest

from meshlab_symrecon.host.free_memory import available_memory, used_memory

GIGABYTE = 10**9


@pytest.fixture
def machine(tmp_path):
    """Return a function that writes the files of a machine with 8 GB free."""

    def written(files):
        files = {"proc/meminfo": "MemTotal: 16000000 kB\nMemAvailable: 7812500 kB\n"} | files
        for name, text in files.items():
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        return available_memory(tmp_path)

    return written


def test_what_the_machine_has_free(machine):
    assert machine({}) == 8 * GIGABYTE


def test_groups_of_version_two_up_to_the_top(machine):
    group = "sys/fs/cgroup/pod/job"
    files = {
        "proc/self/cgroup": "0::/pod/job\n",
        f"{group}/memory.max": "max\n",
        f"{group}/memory.current": "100000000\n",
        "sys/fs/cgroup/pod/memory.max": "4000000000\n",
        "sys/fs/cgroup/pod/memory.current": "1500000000\n",
        "sys/fs/cgroup/pod/memory.stat": "anon 7\ninactive_file 500000000\n",
    }
    assert machine(files) == 3 * GIGABYTE
    assert machine({f"{group}/memory.high": "2100000000\n"}) == 2 * GIGABYTE


def test_groups_of_version_one_inside_a_container(machine):
    top = "sys/fs/cgroup/memory"
    files = {
        "proc/self/cgroup": "5:cpu,cpuacct:/docker/ab\n4:memory:/docker/ab\n0::/\n",
        f"{top}/memory.limit_in_bytes": "2000000000\n",
        f"{top}/memory.usage_in_bytes": "1500000000\n",
        f"{top}/memory.stat": "inactive_file 1\ntotal_inactive_file 500000000\n",
    }
    assert machine(files) == GIGABYTE
    assert machine({f"{top}/memory.limit_in_bytes": "9223372036854771712\n"}) == 8 * GIGABYTE


def test_a_group_that_is_full_leaves_nothing(machine):
    files = {
        "proc/self/cgroup": "0::/\n",
        "sys/fs/cgroup/memory.max": "1000\n",
        "sys/fs/cgroup/memory.current": "5000\n",
    }
    assert machine(files) == 0


def test_without_such_files_the_machine_is_asked_otherwise(tmp_path):
    assert 10**6 < available_memory(tmp_path) < 2**60
    assert used_memory(tmp_path) >= 0


def test_this_machine():
    assert 10**6 < available_memory() < 2**60
    assert 10**6 < used_memory() < resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 * 1.1


@pytest.mark.skipif(sys.platform != "linux", reason="limits of a process are counted on Linux")
def test_the_limits_of_the_process_count():
    program = (
        "import resource\n"
        "from meshlab_symrecon.host.free_memory import available_memory\n"
        "resource.setrlimit(resource.RLIMIT_AS, (20 * 10**9, 20 * 10**9))\n"
        "before = available_memory()\n"
        "resource.setrlimit(resource.RLIMIT_DATA, (10**9, 10**9))\n"
        "after = available_memory()\n"
        "assert before < 20 * 10**9 and 0 < after < 10**9, (before, after)\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
