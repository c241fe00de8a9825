"""A Slurm cluster of one host: munged, slurmctld and two slurmd on the loopback, on ports of their own, without systemd."""

import os
import shutil
import signal
import socket
import subprocess
import time
from pathlib import Path

NEEDED = ["munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel", "sinfo"]
NODES = ["node0", "node1"]

CONF = """\
ClusterName=sandbox
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort={controller}
AuthType=auth/munge
AuthInfo=socket={work}/run/munge
SlurmUser={user}
SlurmdUser={user}
StateSaveLocation={work}/state
SlurmdSpoolDir={work}/spool.%n
SlurmctldPidFile={work}/run/slurmctld.pid
SlurmdPidFile={work}/run/%n.pid
SlurmctldLogFile={work}/slurmctld.log
SlurmdLogFile={work}/%n.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
SlurmdTimeout=8
SchedulerParameters=sched_min_interval=0,bf_interval=1
NodeName=node0 NodeHostname=localhost NodeAddr=127.0.0.1 Port={node0} CPUs=1 RealMemory=16000 State=UNKNOWN
NodeName=node1 NodeHostname=localhost NodeAddr=127.0.0.1 Port={node1} CPUs=1 RealMemory=16000 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES State=UP
"""


def missing():
    """The programs that are not there."""
    path = os.environ.get("PATH", "") + ":/usr/sbin"
    return [name for name in NEEDED if not shutil.which(name, path=path)]


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class Cluster:
    """Started by `with`; what it started ends with it."""

    def __init__(self, work):
        self.work = Path(work)
        self.environment = dict(os.environ, SLURM_CONF=str(self.work / "slurm.conf"))
        self.environment["PATH"] += ":/usr/sbin"

    def __enter__(self):
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    def start(self):
        self.work.chmod(0o755)
        for name in ["run", "state", *(f"spool.{node}" for node in NODES)]:
            (self.work / name).mkdir()
        controller, node0, node1 = free_ports(3)
        user = subprocess.run(["id", "-un"], capture_output=True, text=True, check=True).stdout.strip()
        conf = CONF.format(work=self.work, user=user, controller=controller, node0=node0, node1=node1)
        (self.work / "slurm.conf").write_text(conf)
        key = self.work / "key"
        key.touch(mode=0o600)
        key.write_bytes(os.urandom(1024))
        self.call("munged", "--force", f"--key-file={key}", f"--socket={self.work}/run/munge",
                  f"--pid-file={self.work}/run/munged.pid", f"--log-file={self.work}/munged.log", f"--seed-file={self.work}/seed")
        self.call("slurmctld", "-c")
        for node in NODES:
            self.start_node(node)
        self.wait("nodes that are idle", lambda: self.call("sinfo", "-h", "-N", "-o", "%T").split() == ["idle"] * len(NODES))

    def start_node(self, node):
        self.call("slurmd", "-N", node)

    def kill_node(self, node):
        """kill -9: no goodbye to the controller."""
        os.kill(self.pid(node), signal.SIGKILL)

    def pid(self, name):
        return int((self.work / "run" / f"{name}.pid").read_text())

    def call(self, *command, **settings):
        done = subprocess.run([str(word) for word in command], env=self.environment, capture_output=True, text=True, timeout=120, **settings)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(map(str, command))}: {done.stderr.strip() or done.stdout.strip()}")
        return done.stdout

    def wait(self, what, condition, seconds=120):
        for _ in range(int(seconds / 0.25)):
            if condition():
                return
            time.sleep(0.25)
        queue = self.call("squeue", "-a")
        raise RuntimeError(f"no {what} after {seconds} s\n{queue}")

    def jobs(self, state=None):
        """The tasks that are not done."""
        wanted = ["-t", state] if state else []
        return self.call("squeue", "-h", "-r", "-o", "%i %j %T", *wanted).splitlines()

    def stop(self):
        subprocess.run(["scancel", "--full", "-u", str(os.getuid())], env=self.environment, capture_output=True, check=False)
        for name in [*NODES, "slurmctld", "munged"]:
            try:
                os.kill(self.pid(name), signal.SIGTERM)
            except (OSError, ValueError):
                pass
        time.sleep(1)
