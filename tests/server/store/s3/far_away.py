#!/usr/bin/python3
"""Runs a command whose S3 server is far away: what MESHGAUGE_TEST_S3 names is reached over a proxy that delays.

    with_ceph.py tests/server/store/s3/far_away.py 50 build/tests/server/store/s3/s3_bench

50 ms there and back. As over TCP, a connection has no more than 4 MiB under way: what Linux lets a sender buffer, unless
told otherwise.
"""
import asyncio
import os
import sys
import urllib.parse

WINDOW = 4 << 20
PIECE = 1 << 16


async def carry(reader, writer, way_s):
    """One direction of one connection. Bytes count as under way until their acknowledgement is back."""
    loop, pieces, room = asyncio.get_running_loop(), asyncio.Queue(), asyncio.Semaphore(WINDOW // PIECE)

    async def deliver():
        while True:
            due, piece = await pieces.get()
            await asyncio.sleep(max(0, due - loop.time()))
            if not piece:
                return writer.close()
            writer.write(piece)
            await writer.drain()
            loop.call_later(way_s, room.release)

    delivery = asyncio.create_task(deliver())
    try:
        while not delivery.done():
            await room.acquire()
            piece = await reader.read(PIECE)
            pieces.put_nowait((loop.time() + way_s, piece))
            if not piece:
                return await delivery
    except OSError:
        delivery.cancel()
        writer.close()


async def serve(host, port, way_s, command):
    async def connected(reader, writer):
        await asyncio.sleep(2 * way_s)  # of the handshake
        far_reader, far_writer = await asyncio.open_connection(host, port)
        await asyncio.gather(carry(reader, far_writer, way_s), carry(far_reader, writer, way_s), return_exceptions=True)

    server = await asyncio.start_server(connected, "127.0.0.1", 0)
    near = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"
    process = await asyncio.create_subprocess_exec(*command, env=os.environ | {"MESHGAUGE_TEST_S3": near})
    return await process.wait()


def main():
    server = urllib.parse.urlsplit(os.environ["MESHGAUGE_TEST_S3"])
    raise SystemExit(asyncio.run(serve(server.hostname, server.port, float(sys.argv[1]) / 2000, sys.argv[2:])))


if __name__ == "__main__":
    main()
