"""Maps in object stores: the same answers as from the disk, few requests, and errors where the store fails.

Against a plain server of ranges that fails as it is told, and moto's server of S3's protocol.
"""

import argparse
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from directories import Directories
from servers import RangeServer, S3Server, settings

TIME_LIMIT = 300
# The least that comes while a map is opened, whatever is asked for; see RemoteFile.
OPENING_REQUESTS = 2


class Failed(Exception):
    """A promise was broken; the text says which."""


def hold(condition, text):
    if not condition:
        raise Failed(text)


class Tool:
    def __init__(self, program):
        self.program = str(Path(program).resolve())

    def start(self, *arguments, **environment):
        command = [self.program, *map(str, arguments)]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=settings(**environment))

    def end(self, process):
        stdout, stderr = process.communicate(timeout=TIME_LIMIT)
        hold(process.returncode in (0, 1) and b"panicked" not in stderr, f"exit code {process.returncode}: {stderr}")
        return process.returncode, stdout, stderr.decode()

    def run(self, *arguments, **environment):
        code, stdout, stderr = self.end(self.start(*arguments, **environment))
        hold(code == 0, f"{arguments}: {stderr}")
        return stdout, stderr

    def refuse(self, *arguments, **environment):
        """The error line of a run that must fail."""
        code, _, stderr = self.end(self.start(*arguments, **environment))
        return error_line(code, stderr)


def error_line(code, stderr):
    lines = stderr.splitlines()
    hold(code == 1 and len(lines) == 1 and lines[0].startswith("error: "), f"exit code {code}: {stderr}")
    return lines[0]


class Maps:
    """A map on the disk, points in it, and what they are answered from there."""

    def __init__(self, folder, baker, count):
        self.folder = Path(folder)
        self.path = self.folder / "hair.dsm"
        bake = ["builtin:hairball", "--resolution", "512", "--samples", "4", "--tile", "32", "--block", "none", "--mip"]
        baker.run("bake", *bake, "--quiet", "-o", self.path)
        baker.run("bake", *bake, "--seed", "1", "--quiet", "-o", self.folder / "other.dsm")
        self.tiles = Directories(self.path)
        self.baker = baker
        (self.folder / "empty.dsm").touch()
        chance = random.Random(20)
        size = self.tiles.width
        # Everywhere; and in every third tile alone, in an order that jumps.
        everywhere = [[chance.random() * size, chance.random() * size, 1 + 6 * chance.random()] for _ in range(count)]
        self.all = self.points("all", everywhere)
        third = [tile for index, tile in enumerate(sorted(self.tiles.tiles)) if index % 3 == 0]
        chance.shuffle(third)
        edge = self.tiles.tile_width
        places = [(tile, chance.random(), chance.random()) for tile in third for _ in range(50)]
        apart = [[(x + u) * edge, (y + v) * edge, 1 + 6 * chance.random()] for (x, y), u, v in places]
        self.apart = self.points("apart", apart)

    def points(self, name, points):
        path = self.folder / f"{name}.csv"
        lines = "".join("%.9g,%.9g,%.9g\n" % tuple(point) for point in points)
        path.write_text("x,y,z\n" + lines)
        stdout, _ = self.baker.run("lookup", self.path, "--points", path, "--space", "raster")
        hold(len(set(stdout.split())) > 100, "the points are all alike")
        return Points(path, stdout, *self.tiles.touched(points))


class Points:
    def __init__(self, path, answer, tiles, tile_bytes):
        self.path, self.answer, self.tiles, self.tile_bytes = path, answer, tiles, tile_bytes

    def arguments(self, address):
        return ("lookup", address, "--points", self.path, "--space", "raster")


def counts(server, tiles, tile_bytes, title):
    """Holds a server's requests to what was promised of them."""
    requests = server.requests()
    hold(all(request["status"] == 206 for request in requests), f"{title}: {requests[-3:]}")
    hold(all(request["condition"] for request in requests[1:]), f"{title}: requests without a condition")
    opening, rest = requests[:OPENING_REQUESTS], requests[OPENING_REQUESTS:]
    sent = sum(request["sent"] for request in rest)
    text = f"{title}: {len(opening)} + {len(rest)} requests for {tiles} tiles, {sent / max(tile_bytes, 1):.3f} of their bytes"
    hold(len(rest) <= tiles and sent <= 1.3 * tile_bytes, text)
    return text


def check_lookups(maps, tool, folder):
    texts = []
    for title, points in (("everywhere", maps.all), ("every third tile", maps.apart)):
        with tempfile.TemporaryDirectory() as logs, RangeServer(maps.folder, logs) as server:
            stdout, stderr = tool.run(*points.arguments(server.url("hair.dsm")))
            hold(stdout == points.answer, f"{title}: other answers than from the disk")
            hold("checksums" not in stderr, stderr)
            texts.append(counts(server, points.tiles, points.tile_bytes, title))
    return "; ".join(texts)


def check_scan(maps, tool, folder):
    with RangeServer(maps.folder, folder) as server:
        tool.run("verify", server.url("hair.dsm"))
        requests = server.requests()
        sent = sum(request["sent"] for request in requests)
        share = sent / maps.path.stat().st_size
        text = f"{len(requests)} requests for {len(maps.tiles.tiles)} tiles and the levels above, {share:.3f} of the file"
        hold(len(requests) < len(maps.tiles.tiles) / 3 and share < 1.3, text)
        return text


def check_faults(maps, tool, folder):
    texts = []
    for fault in ("short", "reset", "busy", "slow"):
        for tell in ("etag", "weak", "time", "nothing"):
            arguments = ["--fault", fault, "--every", "7" if fault != "slow" else "40", "--tell", tell]
            with tempfile.TemporaryDirectory() as logs, RangeServer(maps.folder, logs, *arguments) as server:
                address = server.url("hair.dsm")
                stdout, stderr = tool.run(*maps.apart.arguments(address), DEEPSHADOW_REMOTE_TIMEOUT="1")
                hold(stdout == maps.apart.answer, f"{fault}, {tell}: other answers than from the disk")
                said = "checksums alone" in stderr
                hold(said == (tell in ("time", "nothing")), f"{fault}, {tell}: {stderr!r}")
                texts.append(len(server.requests()))
    # What never gets better ends, and soon.
    for fault, reason in (("short", "bytes came"), ("busy", "SlowDown"), ("slow", "no answer within"), ("whole", "byte ranges")):
        with tempfile.TemporaryDirectory() as logs, RangeServer(maps.folder, logs, "--fault", fault, "--every", "1") as server:
            started = time.monotonic()
            patience = {"DEEPSHADOW_REMOTE_TIMEOUT": "0.5", "DEEPSHADOW_REMOTE_RETRIES": "2"}
            line = tool.refuse(*maps.apart.arguments(server.url("hair.dsm")), **patience)
            hold(reason in line and server.url("hair.dsm") in line, f"{fault}: {line}")
            hold(time.monotonic() - started < 30, f"{fault}: took {time.monotonic() - started:.1f} s to end")
    return f"requests: {texts}"


def in_the_middle(tool, server, arguments, act, **environment):
    """Runs the program, and acts once it has read some tiles."""
    before = len(server.requests())
    process = tool.start(*arguments, **environment)
    for _ in range(3000):
        if len(server.requests()) > before + 20:
            break
        time.sleep(0.01)
    hold(process.poll() is None, "the program was done before anything could happen")
    act()
    return tool.end(process)


def check_restart(maps, tool, folder):
    with RangeServer(maps.folder, folder, "--delay", "0.02") as server:

        def restart():
            server.kill()
            time.sleep(1)
            server.start()

        arguments = (*maps.apart.arguments(server.url("hair.dsm")), "--threads", "2")
        code, stdout, stderr = in_the_middle(tool, server, arguments, restart)
        hold(code == 0 and stdout == maps.apart.answer, f"a server that was away for a second: {stderr}")
        code, _, stderr = in_the_middle(tool, server, arguments, server.kill, DEEPSHADOW_REMOTE_RETRIES="2")
        line = error_line(code, stderr)
        hold("refused" in line, line)
        return line


def check_replaced(maps, tool, folder):
    lines = []
    for tell in ("etag", "weak", "time", "nothing"):
        with tempfile.TemporaryDirectory() as root:
            served = Path(root) / "map.dsm"
            served.write_bytes(maps.path.read_bytes())
            os.utime(served, (1, 1))
            with tempfile.TemporaryDirectory() as logs, RangeServer(root, logs, "--delay", "0.02", "--tell", tell) as server:

                def replace():
                    new = Path(root) / "new"
                    new.write_bytes((maps.folder / "other.dsm").read_bytes())
                    new.rename(served)

                arguments = (*maps.apart.arguments(server.url("map.dsm")), "--threads", "2")
                code, stdout, stderr = in_the_middle(tool, server, arguments, replace)
                # A server that tells nothing has its warning before the error, if the map opened so far.
                lines.append(error_line(code, "\n".join(line for line in stderr.splitlines() if "warning" not in line)))
                hold(tell == "nothing" or "replaced" in lines[-1], lines[-1])
    return lines[0]


def check_refusals(maps, tool, folder):
    with RangeServer(maps.folder, folder) as server:
        for address, reason in (
            (server.url("nothing.dsm"), "no such object"),
            (server.url("all.csv"), "not a .dsm file"),
            (server.url("empty.dsm"), "the object is empty"),
            (server.url("hair.dsm") + "?sig=hidden", "behind a ?"),
            (server.url("hair.dsm").replace("//", "//me:hidden@"), "user or key"),
            ("http://127.0.0.1:1/hair.dsm", "refused"),
            ("https://127.0.0.1:1/hair.dsm", "refused"),
            ("gs://bucket", "names no file"),
        ):
            for command in (("inspect", address), maps.apart.arguments(address)):
                line = tool.refuse(*command, DEEPSHADOW_REMOTE_RETRIES="0")
                hold(reason in line and "hidden" not in line, f"{address}: {line}")
        line = tool.refuse("inspect", server.url("hair.dsm"), DEEPSHADOW_REMOTE_RETRIES="many")
        hold("DEEPSHADOW_REMOTE_RETRIES" in line, line)
    return "all in one line"


def size_of(folder):
    return sum(path.stat().st_size for path in Path(folder).glob("*.range"))


def check_cache(maps, tool, folder):
    with tempfile.TemporaryDirectory() as logs, RangeServer(maps.folder, logs) as server:
        arguments = maps.apart.arguments(server.url("hair.dsm"))
        cache = {"DEEPSHADOW_REMOTE_CACHE": folder}
        for _ in range(2):
            before = len(server.requests())
            stdout, _ = tool.run(*arguments, **cache)
            hold(stdout == maps.apart.answer, "other answers through the cache")
        asked = len(server.requests()) - before
        hold(asked == OPENING_REQUESTS, f"{asked} requests of a map that the cache holds")
        # Less than the map: several processes at once keep to it, and answer as ever.
        budget = maps.apart.tile_bytes // 4
        small = {**cache, "DEEPSHADOW_REMOTE_CACHE_BYTES": str(budget)}
        processes = [tool.start(*arguments, **small) for _ in range(4)]
        most = 0
        while any(process.poll() is None for process in processes):
            time.sleep(0.02)
        for process in processes:
            code, stdout, stderr = tool.end(process)
            hold(code == 0 and stdout == maps.apart.answer, stderr)
        most = size_of(folder)
        hold(budget / 2 <= most <= budget, f"{most} bytes in a cache of {budget}")
        # Damage is no answer.
        for path in Path(folder).glob("*.range"):
            path.write_bytes(path.read_bytes()[:-100] + bytes(100))
        stdout, _ = tool.run(*arguments, **small)
        hold(stdout == maps.apart.answer, "other answers through a damaged cache")
        return f"{OPENING_REQUESTS} requests the second time, {most} of {budget} bytes"


def check_put(maps, tool, folder):
    root = Path(folder)
    with tempfile.TemporaryDirectory() as logs, RangeServer(root, logs) as server:
        tool.run("convert", maps.path, server.url("copy.dsm"), "--quiet", "--tolerance", "0.05")
        tool.run("convert", maps.path, root / "local.dsm", "--quiet", "--tolerance", "0.05")
        hold((root / "copy.dsm").read_bytes() == (root / "local.dsm").read_bytes(), "another file arrived")
    # What cannot be sent is kept.
    temporary = root / "tmp"
    temporary.mkdir()
    address = server.url("copy.dsm")
    command = ("convert", maps.path, address, "--quiet", "--tolerance", "0.05")
    line = tool.refuse(*command, DEEPSHADOW_REMOTE_RETRIES="1", TMPDIR=str(temporary))
    kept = list(temporary.iterdir())
    hold(len(kept) == 1 and str(kept[0]) in line and address in line, line)
    hold(kept[0].read_bytes() == (root / "local.dsm").read_bytes(), "another file was kept")
    return line


def check_s3(maps, tool, folder):
    root = Path(folder)
    with S3Server(folder) as server:
        client = server.client()
        client.create_bucket(Bucket="maps")
        s3 = server.settings

        def get(name):
            return client.get_object(Bucket="maps", Key=name)["Body"].read()

        # In one piece, and in parts.
        scene = ["builtin:pipes", "--resolution", "64", "--quiet"]
        tool.run("bake", *scene, "-o", "s3://maps/a folder/pipes.dsm".replace(" ", "%20"), **s3)
        tool.run("bake", *scene, "-o", root / "pipes.dsm")
        hold(get("a folder/pipes.dsm") == (root / "pipes.dsm").read_bytes(), "bake: another file arrived")
        plain = root / "plain.dsm"
        tool.run("convert", maps.path, plain, "--block", "none", "--tile", "32", "--quiet")
        client.upload_file(str(plain), "maps", "plain.dsm")
        tool.run("mip", "s3://maps/plain.dsm", "-o", "s3://maps/mip.dsm", "--quiet", **s3)
        tool.run("mip", plain, "-o", root / "mip.dsm", "--quiet")
        length = (root / "mip.dsm").stat().st_size
        hold(get("mip.dsm") == (root / "mip.dsm").read_bytes() and length > 2 << 23, f"mip: another file, or {length} bytes in one part")
        hair = ("builtin:hairball", "--resolution", "128", "--samples", "1", "--tile", "32")
        for half, crop in (("left", "0,0,64,128"), ("right", "64,0,128,128")):
            tool.run("bake", *hair, "--crop", crop, "--quiet", "-o", f"s3://maps/{half}.dsm", **s3)
        tool.run("merge", "s3://maps/left.dsm", "s3://maps/right.dsm", "-o", "s3://maps/whole.dsm", "--quiet", **s3)
        tool.run("bake", *hair, "--quiet", "-o", root / "whole.dsm")
        hold(get("whole.dsm") == (root / "whole.dsm").read_bytes(), "merge: another file than a whole bake")
        tool.run("convert", "s3://maps/whole.dsm", "s3://maps/whole.exr", "--quiet", **s3)
        tool.run("verify", "s3://maps/whole.dsm", "--against", "s3://maps/whole.exr", **s3)

        client.upload_file(str(maps.path), "maps", "hair.dsm")
        before = server.gets("maps/hair.dsm")
        stdout, _ = tool.run(*maps.apart.arguments("s3://maps/hair.dsm"), **s3)
        hold(stdout == maps.apart.answer, "other answers than from the disk")
        asked = server.gets("maps/hair.dsm") - before
        hold(asked <= OPENING_REQUESTS + maps.apart.tiles, f"{asked} requests for {maps.apart.tiles} tiles")

        process = tool.start(*maps.all.arguments("s3://maps/hair.dsm"), "--threads", "1", **s3)
        before = server.gets("maps/hair.dsm")
        while server.gets("maps/hair.dsm") < before + 10 and process.poll() is None:
            time.sleep(0.01)
        hold(process.poll() is None, "the program was done before anything could happen")
        client.upload_file(str(maps.folder / "other.dsm"), "maps", "hair.dsm")
        line = error_line(*tool.end(process)[::2])
        hold("replaced" in line, line)

        line = tool.refuse("inspect", "s3://maps/nothing.dsm", **s3)
        hold("no such object" in line and "s3://maps/nothing.dsm" in line, line)
        line = tool.refuse("bake", *scene, "-o", "s3://nowhere/pipes.dsm", TMPDIR=folder, **s3)
        hold("kept as" in line and "secret" not in line, line)
        # Plain HTTP is for endpoints that are written so.
        line = tool.refuse("inspect", "s3://maps/whole.dsm", **{**s3, "AWS_ENDPOINT_URL": "https://127.0.0.1:1"}, DEEPSHADOW_REMOTE_RETRIES="0")
        return f"{asked} requests for {maps.apart.tiles} tiles"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tools", required=True, type=Path, help="the program dsm-tools, built with the feature remote")
    parser.add_argument("--baker", type=Path, help="the program that bakes what is looked up; the same if not told")
    parser.add_argument("--points", type=int, default=100_000)
    parser.add_argument("--only", help="the check to run")
    arguments = parser.parse_args()
    tool = Tool(arguments.tools)
    failed = 0
    checks = {name.removeprefix("check_"): check for name, check in globals().items() if name.startswith("check_")}
    with tempfile.TemporaryDirectory() as shared:
        maps = Maps(shared, Tool(arguments.baker or arguments.tools), arguments.points)
        for name, check in checks.items():
            if arguments.only not in (None, name):
                continue
            started = time.monotonic()
            try:
                with tempfile.TemporaryDirectory() as folder:
                    outcome = check(maps, tool, folder)
            except (Failed, RuntimeError, subprocess.TimeoutExpired) as error:
                outcome = f"FAILED: {error}"
                failed += 1
            print(f"{name}: {outcome} ({time.monotonic() - started:.1f} s)", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
