"""Time, peak memory and error of solves and areas from one version to the next, by asv (airspeed velocity).

pip install asv
cd benchmarks
asv run --quick --environment existing:python          # what is installed
asv continuous main HEAD && asv publish && asv preview  # versions beside each other
"""
