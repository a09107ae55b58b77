#!/bin/sh
# Stands in for the program: leaves half a file beside the one to write, with its own process
# number, and goes on until it is killed.
while [ "$1" != --output ]; do shift; done
echo $$ > "${2%/*}/.trackwright-half.tmp"
exec sleep 600
