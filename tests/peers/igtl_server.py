"""Serves transforms with pyigtl until the input ends: one for each line, `NAME X VERSION STATUS`."""

import sys
import time

import numpy
import pyigtl

server = pyigtl.OpenIGTLinkServer(port=int(sys.argv[1]), local_server=True)
for line in sys.stdin:
    name, x, version, status = line.split()
    matrix = numpy.eye(4)
    matrix[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    matrix[:3, 3] = [float(x), 20, 30]
    message = pyigtl.TransformMessage(matrix, device_name=name)
    message.header_version = int(version)
    if message.header_version == 2:
        message.metadata = {"TransformStatus": status}
    while not server.is_connected():
        time.sleep(0.005)
    server.send_message(message, wait=True)
    print("sent", flush=True)
server.stop()
