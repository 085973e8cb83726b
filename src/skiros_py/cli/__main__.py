"""``python -m skiros_py.cli``."""

from skiros_py.cli.main import main

if __name__ == "__main__":
    main()
