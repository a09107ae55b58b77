"""Receives transforms of a tool with pyigtl and prints the metadata of each, as JSON, a line each."""

import json
import sys

import pyigtl

client = pyigtl.OpenIGTLinkClient(host="127.0.0.1", port=int(sys.argv[1]))
count = 0
while count < int(sys.argv[3]):
    message = client.wait_for_message(sys.argv[2], timeout=60)
    if message is None:
        break
    if isinstance(message, pyigtl.TransformMessage):
        print(json.dumps(message.metadata), flush=True)
        count += 1
client.stop()
