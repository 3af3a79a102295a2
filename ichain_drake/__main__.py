"""`python -m ichain_drake` is `ichain`."""

import sys

from ichain_drake.cli.main import main

sys.exit(main())
