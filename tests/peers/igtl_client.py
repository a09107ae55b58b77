"""Receives the transform of a tool with pyigtl and prints it with its metadata, as JSON."""

import json
import sys

import pyigtl

client = pyigtl.OpenIGTLinkClient(host="127.0.0.1", port=int(sys.argv[1]))
while True:
    message = client.wait_for_message(sys.argv[2], timeout=60)
    if message is None or isinstance(message, pyigtl.TransformMessage):
        break
print(
    json.dumps(
        {
            "matrix": message.matrix.tolist(),
            "timestamp": message.timestamp,
            "version": message.header_version,
            "metadata": message.metadata,
        }
    ),
    flush=True,
)
client.stop()
