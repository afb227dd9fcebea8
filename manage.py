#!/usr/bin/env python
"""Django's command line."""

from portal.command import main

if __name__ == "__main__":
    main()
