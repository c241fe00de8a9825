"""A plain HTTP server of a folder that answers byte ranges, as badly as it is told.

Every request is a line of JSON in the log: method, range, status, bytes sent.
"""

import argparse
import email.utils
import http.server
import json
import os
import re
import socket
import threading
import time
from pathlib import Path


class Server(http.server.ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, arguments):
        super().__init__(("127.0.0.1", arguments.port), Handler)
        self.arguments = arguments
        self.lock = threading.Lock()
        self.count = 0

    def handle_error(self, request, address):
        """Clients may go away."""


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *_):
        pass

    def note(self, status, sent):
        line = {"method": self.command, "range": self.headers.get("Range"), "status": status, "sent": sent}
        line["condition"] = self.headers.get("If-Match") or self.headers.get("If-Unmodified-Since")
        with self.server.lock, open(self.server.arguments.log, "a") as log:
            log.write(json.dumps(line) + "\n")

    def path_of_file(self):
        return Path(self.server.arguments.root) / self.path.lstrip("/")

    def answer(self, status, headers=(), body=b""):
        self.send_response(status)
        for name, value in headers:
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)
        self.note(status, len(body))

    def do_PUT(self):
        path = self.path_of_file()
        partial = path.with_suffix(".upload")
        partial.write_bytes(self.rfile.read(int(self.headers["Content-Length"])))
        partial.rename(path)
        self.answer(201)

    def do_HEAD(self):
        self.do_GET()

    def do_GET(self):
        arguments = self.server.arguments
        with self.server.lock:
            self.server.count += 1
            is_bad = arguments.every and self.server.count % arguments.every == 0
        fault = arguments.fault if is_bad else None
        time.sleep(arguments.delay)
        if fault == "slow":
            time.sleep(arguments.sleep)
        if fault == "busy":
            return self.answer(503, body=b"<Error>\n  <Code>SlowDown</Code>\n</Error>")
        try:
            with open(self.path_of_file(), "rb") as file:
                told = os.fstat(file.fileno())
                data = file.read()
        except OSError:
            return self.answer(404, body=b"no such\nfile")
        etag = '"%x-%x-%x"' % (told.st_ino, told.st_mtime_ns, told.st_size)
        date = email.utils.formatdate(told.st_mtime, usegmt=True)
        headers = {
            "etag": [("ETag", etag), ("Last-Modified", date)],
            "weak": [("ETag", "W/" + etag)],
            "time": [("Last-Modified", date)],
            "nothing": [],
        }[arguments.tell]
        condition = self.headers.get("If-Match")
        if condition and condition != etag:
            return self.answer(412)
        since = self.headers.get("If-Unmodified-Since")
        if since and email.utils.parsedate_to_datetime(since).timestamp() < int(told.st_mtime):
            return self.answer(412)
        wanted = re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers.get("Range", ""))
        if not wanted or fault == "whole":
            return self.answer(200, headers, data)
        start, end = int(wanted[1]), min(int(wanted[2]) + 1, len(data))
        if start >= len(data):
            return self.answer(416, [("Content-Range", f"bytes */{len(data)}")])
        body = data[start:end]
        headers.append(("Content-Range", f"bytes {start}-{end - 1}/{len(data)}"))
        if fault in ("short", "reset"):
            # Either as if that were all, or with a connection that breaks.
            part = body[: len(body) // 2]
            self.send_response(206)
            for name, value in headers:
                self.send_header(name, value)
            self.send_header("Content-Length", str(len(part) if fault == "short" else len(body)))
            self.end_headers()
            self.wfile.write(part)
            self.note(206, len(part))
            if fault == "reset":
                self.wfile.flush()
                self.connection.shutdown(socket.SHUT_RDWR)
            return None
        return self.answer(206, headers, body)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--root", required=True)
    parser.add_argument("--log", required=True)
    parser.add_argument("--port", type=int, required=True)
    parser.add_argument("--tell", default="etag", choices=["etag", "weak", "time", "nothing"])
    parser.add_argument("--fault", choices=["short", "reset", "slow", "busy", "whole"])
    parser.add_argument("--every", type=int, default=0, help="each such request goes wrong")
    parser.add_argument("--sleep", type=float, default=3.0, help="seconds of a slow answer")
    parser.add_argument("--delay", type=float, default=0.0, help="seconds of every answer")
    Server(parser.parse_args()).serve_forever()


if __name__ == "__main__":
    main()
