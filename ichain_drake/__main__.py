"""`python -m ichain_drake` is `ichain`."""

import sys

from ichain_drake.cli.start import main

sys.exit(main())
