"""Greatest resident memory of a command, in bytes, on the last line: peak_memory.py COMMAND ARGUMENTS..."""

import resource
import subprocess
import sys

answer = subprocess.run(sys.argv[1:], stdout=subprocess.PIPE, check=True).stdout
if not answer:
    sys.exit("the command gave no answer")
peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
print(peak if sys.platform == "darwin" else 1024 * peak)
