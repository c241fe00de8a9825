"""Servers that the checks start, stop and count the requests of."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
# S3's client asks for all of them; the server takes any.
S3_SETTINGS = {"AWS_ACCESS_KEY_ID": "key", "AWS_SECRET_ACCESS_KEY": "secret-of-the-checks", "AWS_REGION": "us-east-1"}


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Process:
    """A server at a port of this machine."""

    def __init__(self, command, port, log):
        self.command, self.port, self.log = command, port, Path(log)
        self.start()

    def start(self):
        self.process = subprocess.Popen(self.command, stdout=subprocess.DEVNULL, stderr=open(f"{self.log}.stderr", "a"))
        for _ in range(600):
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", self.port)) == 0:
                    return
            if self.process.poll() is not None:
                break
            time.sleep(0.05)
        raise RuntimeError(f"{self.command[0]} does not answer at port {self.port}")

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.kill()


class RangeServer(Process):
    def __init__(self, root, folder, *arguments):
        port, log = free_port(), Path(folder) / "requests"
        log.touch()
        command = [sys.executable, HERE / "range_server.py", "--root", root, "--log", log, "--port", str(port), *arguments]
        super().__init__(list(map(str, command)), port, log)

    def url(self, name):
        return f"http://127.0.0.1:{self.port}/{name}"

    def requests(self):
        return [json.loads(line) for line in self.log.read_text().splitlines()]


class S3Server(Process):
    def __init__(self, folder):
        port = free_port()
        program = Path(sys.executable).with_name("moto_server")
        super().__init__([str(program), "-H", "127.0.0.1", "-p", str(port)], port, Path(folder) / "s3")
        self.settings = {**S3_SETTINGS, "AWS_ENDPOINT_URL": f"http://127.0.0.1:{port}"}

    def client(self):
        import boto3

        return boto3.client(
            "s3",
            endpoint_url=self.settings["AWS_ENDPOINT_URL"],
            aws_access_key_id="key",
            aws_secret_access_key="secret",
            region_name="us-east-1",
        )

    def gets(self, name):
        """The requests for an object so far."""
        lines = Path(f"{self.log}.stderr").read_text().splitlines()
        return sum(f"GET /{name} " in line for line in lines)


def settings(**more):
    """The environment of the program: none of the machine's own stores, quick retries."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("AWS_", "DEEPSHADOW_"))}
    return {**kept, **more}
