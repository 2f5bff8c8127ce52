"""`python -m photonmap`."""

import sys

from photonmap.cli import main

sys.exit(main())
