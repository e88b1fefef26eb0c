"""The thresholds of docs/trust/stability.md and the reasons for them, as the checks have them.

python docs/studies/stability_checks.py
"""

from __future__ import annotations

from doc_tables import DocTable, pick, write_tables

from roughcontact._work.reports.stability_report import RULES

HEADING = ("check", "pass up to (from)", "attention up to (from)", "why")


def list_rules() -> list[list[str]]:
    """Return a line for each threshold; checks that share it and its reason share the line."""
    lines = [list(HEADING)]
    for name, rule in RULES.items():
        limits = [f"{rule.good:g}", f"{rule.admissible:g}"]
        *_, last = lines
        if limits == last[1:3] and (rule.reason == last[3] or rule.reason.startswith("as for")):
            last[0] += f"; {name}"
        else:
            lines.append([name, *limits, rule.reason])
    return lines


TABLES = {"stability-checks": DocTable(list_rules, seconds=1, shown=pick(HEADING[:3]))}

if __name__ == "__main__":
    write_tables(TABLES)
