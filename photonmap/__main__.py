"""`python -m photonmap`."""

import sys

from photonmap.commands.main import main

sys.exit(main())
